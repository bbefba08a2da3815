//! `bench`: the command line of the virtual bench.

use std::io::{self, IsTerminal as _, Write as _};
use std::process::ExitCode;

use bench::args::{self, NotUp, Up};
use bench::run::End;
use bench::state::StateDir;
use bench::{Bench, Setup, images, tui};

/// The bench did not come up: the user can put it right.
const NOT_UP: u8 = 2;
/// It came up and could not go on.
const FAILED: u8 = 1;

fn main() -> ExitCode {
    let up = match args::parse(std::env::args_os()) {
        Ok(up) => up,
        Err(NotUp::Help(text)) => {
            print!("{text}");
            return ExitCode::SUCCESS;
        }
        Err(NotUp::Usage(sentence)) => return refuse(&sentence, NOT_UP),
    };
    let bench = match start(&up) {
        Ok(bench) => bench,
        Err(sentence) => return refuse(&sentence, NOT_UP),
    };
    match run(bench, &up) {
        End::Stopped => ExitCode::SUCCESS,
        End::Failed(sentence) => refuse(&sentence, FAILED),
    }
}

fn start(up: &Up) -> Result<Bench, String> {
    images::check_product(&up.product, up.engine)?;
    let state = up.state.as_deref().map(|dir| StateDir::open(dir, &up.product)).transpose()?;
    let nodes = usize::try_from(up.nodes).unwrap_or(usize::MAX);
    let kept = state.as_ref().map(|state| state.load(nodes)).transpose()?.unwrap_or_default();
    let engine = images::engine(up, kept)?;
    let setup = Setup {
        product: up.product.clone(),
        clock: up.clock,
        slcan: up.slcan,
        socketcand: up.socketcand,
        socketcan: up.socketcan.clone(),
        control: up.control,
        state,
    };
    let bench = Bench::start(setup, engine)?;
    let stopper = bench.stopper();
    ctrlc::set_handler(move || stopper.stop())
        .map_err(|error| format!("the signals that end the bench can not be taken: {error}"))?;
    Ok(bench)
}

fn run(bench: Bench, up: &Up) -> End {
    let mut stdout = io::stdout();
    let written = writeln!(stdout, "{}", bench.ready_line()).and_then(|()| stdout.flush());
    if written.is_err() || up.no_tui || !stdout.is_terminal() || !io::stdin().is_terminal() {
        return bench.wait();
    }
    let shown = tui::show(&bench);
    let end = bench.stop();
    match (shown, end) {
        (Err(error), End::Stopped) => End::Failed(format!("the terminal is unusable: {error}")),
        (Ok(()) | Err(_), end) => end,
    }
}

fn refuse(sentence: &str, code: u8) -> ExitCode {
    eprintln!("bench: {sentence}");
    ExitCode::from(code)
}
