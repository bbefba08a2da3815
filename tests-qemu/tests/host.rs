//! The vectors on the host, as a reference for the emulated board.

/// NM17x POS-01 to POS-05, POS-09, SDO-02 to SDO-05, SDO-10, LINK-02, LINK-03, LINK-07.
#[test]
fn every_vector_comes_out_right() {
    let mut wrong = Vec::new();
    let count = tests_qemu::run(|name| wrong.push(name.to_owned()));
    assert_eq!(wrong, Vec::<String>::new());
    assert!(count > 20, "{count} vectors");
}
