//! Programs on an emulated Cortex-M4, among them the golden vectors of the logic crates.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use crate::images::TARGET;
use crate::run::{self, Failure};

/// The programs take well under a second; one that hangs is stopped.
const TIME_MAX: Duration = Duration::from_secs(60);

/// Builds the image of the vectors and runs it.
pub(crate) fn test() -> Result<(), Failure> {
    run::step(
        run::cargo(["build", "--release", "--package", "tests-qemu", "--features", "image"])
            .args(["--target", TARGET, "--bin", "vectors"])
            // In place of the flags for the boards: another memory map, no log.
            .env("RUSTFLAGS", "-C link-arg=--nmagic"),
    )?;
    let image = run::target_dir().join(TARGET).join("release").join("vectors");
    print!("{}", run(&image, &[])?);
    Ok(())
}

/// Runs an image on the emulated board to its end. Comes back with what it printed.
pub(crate) fn run(image: &Path, options: &[&str]) -> Result<String, Failure> {
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-machine", "mps2-an386", "-cpu", "cortex-m4", "-nographic", "-monitor", "none"])
        .args(["-serial", "none", "-semihosting-config", "enable=on,target=native"])
        .args(options)
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .stdout(Stdio::piped());
    eprintln!("\n--- qemu-system-arm -machine mps2-an386 -kernel {}", image.display());
    let failed = |what: String| Failure::Step(format!("qemu-system-arm: {what}"));
    let mut child = command.spawn().map_err(|e| failed(e.to_string()))?;
    let mut output = child.stdout.take().ok_or_else(|| failed("no output".to_owned()))?;
    let (ended, end) = mpsc::channel();
    std::thread::spawn(move || {
        let mut text = String::new();
        let read = output.read_to_string(&mut text).map(|_| text);
        ended.send(read)
    });
    let text = end.recv_timeout(TIME_MAX);
    if text.is_err() {
        let _ = child.kill();
    }
    let status = child.wait().map_err(|e| failed(e.to_string()))?;
    let Ok(text) = text else {
        return Err(failed(format!("did not end within {} s", TIME_MAX.as_secs())));
    };
    let text = text.map_err(|e| failed(e.to_string()))?;
    if status.success() { Ok(text) } else { Err(failed(format!("{status}\n{text}"))) }
}
