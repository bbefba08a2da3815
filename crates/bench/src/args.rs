//! The command line. Whatever is wrong with it is said in one sentence.

use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand, ValueEnum};

/// Where masters attach by SLCAN unless told otherwise.
pub const SLCAN_DEFAULT: &str = "127.0.0.1:29536";

/// Where the control port listens unless told otherwise.
pub const CONTROL_DEFAULT: &str = "127.0.0.1:29537";

/// Most devices on one bus: as many as there are CANopen node-IDs.
pub const NODES_MAX: u32 = 127;

/// The virtual bench: complete devices on a virtual CAN bus, on their own firmware images.
#[derive(Debug, Parser)]
#[command(name = "bench", version, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Puts devices on a bus and lets CAN masters attach.
    #[command(after_help = AFTER_HELP)]
    Up(Up),
}

const AFTER_HELP: &str = "\
ADDR is HOST:PORT; port 0 takes any free port. The first line on standard output is a JSON object
with the addresses in use.

Images are read from target/thumbv7em-none-eabihf/release (below CARGO_TARGET_DIR when that is set):
stm-PRODUCT and msp-PRODUCT. The environment variable SPINDLE_IMAGES names another directory.

Keys of the terminal: arrow left/right turn the shaft (with shift: faster), space stops it,
a/d hold the left/right key, f/g switch the inputs, p switches the supply, q quits.";

/// Everything `bench up` can be told.
#[derive(Clone, Debug, clap::Args)]
pub struct Up {
    /// The product, such as nm172.
    pub product: String,

    /// What the devices are made of.
    #[arg(long, value_enum, default_value = "image")]
    pub engine: EngineKind,

    /// What moves virtual time.
    #[arg(long, value_enum, default_value = "real")]
    pub clock: Clock,

    /// Devices on the bus, each with its own serial number.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(NODES_MAX)))]
    pub nodes: u32,

    /// Keeps the flash contents of all controllers in this directory between runs.
    #[arg(long, value_name = "DIR")]
    pub state: Option<PathBuf>,

    /// Where SLCAN clients attach.
    #[arg(long, value_name = "ADDR", default_value = SLCAN_DEFAULT, value_parser = address)]
    pub slcan: SocketAddr,

    /// Where socketcand clients attach; not offered unless given.
    #[arg(long, value_name = "ADDR", value_parser = address)]
    pub socketcand: Option<SocketAddr>,

    /// A CAN interface of this computer to join to the virtual bus, as IFACE or IFACE@BITRATE.
    #[arg(long, value_name = "IFACE")]
    pub socketcan: Option<String>,

    /// Where the control port listens.
    #[arg(long, value_name = "ADDR", default_value = CONTROL_DEFAULT, value_parser = address)]
    pub control: SocketAddr,

    /// Runs without the terminal user interface.
    #[arg(long)]
    pub no_tui: bool,

    /// Decides every random event of the run.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
}

/// What the devices are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineKind {
    /// The firmware images, on emulated controllers.
    Image,
    /// The logic of both controllers, without emulation.
    Twin,
}

/// What moves virtual time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Clock {
    /// Virtual time follows the wall clock and never runs ahead of it.
    Real,
    /// Virtual time stands still until the control port advances it.
    Step,
}

/// Why there is nothing to run.
#[derive(Debug, PartialEq, Eq)]
pub enum NotUp {
    /// The user asked for this text.
    Help(String),
    /// The arguments are wrong, for the reason in this sentence.
    Usage(String),
}

/// Reads the command line, program name first.
///
/// # Errors
/// Help was asked for, or an argument is unknown, missing or has a value it can not have.
pub fn parse<I, T>(arguments: I) -> Result<Up, NotUp>
where
    I: IntoIterator<Item = T>,
    T: Into<std::ffi::OsString> + Clone,
{
    match Cli::try_parse_from(arguments) {
        Ok(Cli { verb: Verb::Up(up) }) => Ok(up),
        Err(error) => Err(not_up(&error)),
    }
}

fn not_up(error: &clap::Error) -> NotUp {
    let kind = error.kind();
    if matches!(kind, ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return NotUp::Help(error.to_string());
    }
    if kind == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return NotUp::Usage("nothing to do: try `bench up nm172` or `bench --help`".to_owned());
    }
    // The first paragraph holds the reason; tips and usage follow it.
    let text = error.to_string();
    let reason = text.split("\n\n").next().unwrap_or_default();
    let sentence = reason.split_whitespace().collect::<Vec<_>>().join(" ");
    NotUp::Usage(sentence.trim_start_matches("error: ").to_owned())
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let no_address = || "an address is HOST:PORT, such as 127.0.0.1:0".to_owned();
    text.to_socket_addrs().map_err(|_| no_address())?.next().ok_or_else(no_address)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_options_the_defaults_hold() {
        let up = parse(["bench", "up", "nm172"]).unwrap();
        assert_eq!(up.product, "nm172");
        assert_eq!((up.engine, up.clock, up.nodes), (EngineKind::Image, Clock::Real, 1));
        assert_eq!(up.slcan.to_string(), SLCAN_DEFAULT);
        assert_eq!(up.control.to_string(), CONTROL_DEFAULT);
        assert_eq!((up.socketcand, up.socketcan, up.state), (None, None, None));
        assert_eq!((up.no_tui, up.seed), (false, 0));
    }

    #[test]
    fn wrong_arguments_are_refused_in_one_sentence_that_names_them() {
        for (arguments, named) in [
            (&[][..], "bench up"),
            (&["down"], "down"),
            (&["up"], "<PRODUCT>"),
            (&["up", "nm172", "ap04"], "ap04"),
            (&["up", "nm172", "--frobnicate"], "--frobnicate"),
            (&["up", "nm172", "--engine", "steam"], "steam"),
            (&["up", "nm172", "--clock", "sundial"], "sundial"),
            (&["up", "nm172", "--nodes", "0"], "0"),
            (&["up", "nm172", "--nodes", "128"], "128"),
            (&["up", "nm172", "--seed", "-1"], "-1"),
            (&["up", "nm172", "--slcan", "nowhere"], "HOST:PORT"),
            (&["up", "nm172", "--control", "127.0.0.1:65536"], "HOST:PORT"),
            (&["up", "nm172", "--state"], "--state"),
        ] {
            let line = ["bench"].iter().chain(arguments);
            let NotUp::Usage(sentence) = parse(line.copied()).unwrap_err() else {
                panic!("{arguments:?}: help instead of a refusal");
            };
            assert!(sentence.contains(named), "{arguments:?}: {sentence}");
            assert_eq!(sentence.lines().count(), 1, "{arguments:?}: {sentence}");
        }
    }

    #[test]
    fn help_is_not_an_error() {
        for line in [&["bench", "--help"][..], &["bench", "up", "--help"], &["bench", "--version"]]
        {
            assert!(matches!(parse(line), Err(NotUp::Help(_))), "{line:?}");
        }
    }
}
