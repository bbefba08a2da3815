//! Writing the images to two boards.

use std::process::Command;

use crate::images::{self, Controller};
use crate::run::{self, Failure};
use crate::tools::{self, Tool};

const CHIP: &str = "STM32F429ZITx";

/// Builds both images of a product and writes each to the board its probe was named for.
pub(crate) fn flash(arguments: &[&str]) -> Result<(), Failure> {
    let boards = boards(arguments)?;
    tools::require(&[Tool::ProbeRs])?;
    let probes = probes()?;
    let [stm, msp] = match (boards.stm, boards.msp) {
        (Some(stm), Some(msp)) => [stm, msp],
        _ => return Err(Failure::Missing(advice(&probes, boards.product))),
    };
    for named in [stm, msp] {
        if !probes.iter().any(|probe| probe.contains(named)) {
            let mut lines = vec![format!("no probe `{named}` is connected")];
            lines.extend(advice(&probes, boards.product));
            return Err(Failure::Missing(lines));
        }
    }
    images::build(boards.product)?;
    for (controller, probe) in Controller::BOTH.into_iter().zip([stm, msp]) {
        let image = controller.image(boards.product);
        let probe_rs = |verb: &str| {
            let mut command = Command::new("probe-rs");
            command.args([verb, "--chip", CHIP, "--probe", probe]);
            command
        };
        run::step(probe_rs("download").arg(image))?;
        run::step(&mut probe_rs("reset"))?;
    }
    Ok(())
}

/// What the command line says.
struct Boards<'a> {
    product: &'static str,
    stm: Option<&'a str>,
    msp: Option<&'a str>,
}

fn boards<'a>(arguments: &[&'a str]) -> Result<Boards<'a>, Failure> {
    let (name, mut rest) = arguments
        .split_first()
        .ok_or_else(|| Failure::Usage("which product? Try: cargo xtask flash nm172".to_owned()))?;
    let mut boards = Boards { product: images::product(name)?, stm: None, msp: None };
    while let [option, tail @ ..] = rest {
        rest = match (*option, tail) {
            ("--stm", [probe, tail @ ..]) => {
                boards.stm = Some(probe);
                tail
            }
            ("--msp", [probe, tail @ ..]) => {
                boards.msp = Some(probe);
                tail
            }
            ("--stm" | "--msp", []) => {
                return Err(Failure::Usage(format!("`{option}` needs the name of a probe")));
            }
            _ => return Err(Failure::Usage(format!("`flash` takes no `{option}`"))),
        };
    }
    Ok(boards)
}

/// One line per connected probe, as probe-rs prints them.
fn probes() -> Result<Vec<String>, Failure> {
    let output = Command::new("probe-rs")
        .arg("list")
        .output()
        .map_err(|e| Failure::Step(format!("probe-rs list: {e}")))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.lines().filter(|line| line.starts_with('[')).map(str::to_owned).collect())
}

fn advice(probes: &[String], product: &str) -> Vec<String> {
    let mut lines = match probes.len() {
        0 => vec!["no debug probe is connected: plug in both boards by USB".to_owned()],
        1 => vec!["one debug probe is connected and two are needed:".to_owned()],
        count => vec![format!("{count} debug probes are connected:")],
    };
    lines.extend(probes.iter().map(|probe| format!("  {probe}")));
    lines.push(format!(
        "say which board is which: cargo xtask flash {product} --stm VID:PID:SERIAL --msp \
         VID:PID:SERIAL"
    ));
    lines
}
