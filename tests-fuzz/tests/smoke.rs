//! Every target over its kept seeds, and over bytes that chance makes. Proptest prints the least
//! input that fails; `cargo xtask fuzz` looks further.

use std::path::Path;

use proptest::collection::vec;
use proptest::prelude::*;
use tests_fuzz::{TARGETS, link, lss, node, sdo};

/// What once failed, and what reaches far, stays right.
#[test]
fn the_kept_seeds_pass() {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds");
    for (name, target) in TARGETS {
        let mut kept = 0;
        for entry in std::fs::read_dir(seeds.join(name)).unwrap() {
            let path = entry.unwrap().path();
            println!("{}", path.display());
            target(&std::fs::read(path).unwrap());
            kept += 1;
        }
        assert!(kept > 0, "{name} has no seeds");
    }
}

proptest! {
    /// NM17x NMT-04, PDO-01, HB-01, SDO-01: whatever arrives, the node lives, answers a request
    /// once, uses its own identifiers only, sends what its state permits, and comes to rest.
    #[test]
    fn no_sequence_of_frames_breaks_the_rules(bytes in vec(any::<u8>(), 0..1_500)) {
        node::converse(&bytes);
    }

    /// NM17x SDO-01, SDO-06, SDO-07, SDO-09: each request has the answer of the model.
    #[test]
    fn the_sdo_server_answers_as_its_model(bytes in vec(any::<u8>(), 0..1_500)) {
        sdo::converse(&bytes);
    }

    /// NM17x LSS-01, LSS-09, ADDR-05: each request has the answer of the model.
    #[test]
    fn the_lss_slave_does_as_its_model(bytes in vec(any::<u8>(), 0..1_500)) {
        lss::converse(&bytes);
    }

    /// NM17x LINK-06: whatever comes, the receiver lives, and finds the next frame.
    #[test]
    fn any_line_leaves_a_receiver_that_works(bytes in vec(any::<u8>(), 0..600)) {
        link::converse(&bytes);
    }
}
