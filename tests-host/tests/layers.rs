//! Who may know whom. A package may name those of the workspace that are listed here, and nothing
//! else; so the emulation cannot look into the logic it runs, and the logic cannot reach hardware.

use std::process::Command;

use serde_json::Value;

/// Every package of the workspace, and everything of the workspace it may name.
#[rustfmt::skip]
const MAY_KNOW: &[(&str, &[&str])] = &[
    // Vocabulary
    ("units",             &[]),
    ("object-dictionary", &[]),
    // Subjects
    ("shared-proto",      &[]),
    ("storage",           &[]),
    ("lcd",               &[]),
    ("positioning",       &["units"]),
    ("canopen",           &["object-dictionary", "units"]),
    ("profiles",          &["object-dictionary"]),
    ("dev1",              &["canopen", "object-dictionary"]),
    // Cores
    ("interface",         &["canopen", "object-dictionary", "profiles", "shared-proto", "units"]),
    ("application",       &["lcd", "object-dictionary", "positioning", "profiles", "shared-proto", "units"]),
    ("position-sensor",   &["canopen", "object-dictionary", "profiles", "units"]),
    // Shells
    ("firmware-board",    &["shared-proto", "storage", "units"]),
    ("firmware-stm",      &["canopen", "firmware-board", "interface", "profiles", "shared-proto", "units"]),
    ("firmware-msp",      &["application", "firmware-board", "lcd", "profiles", "shared-proto", "units"]),
    ("firmware-probe",    &[]),
    // Bench
    ("world",             &["units"]),
    ("emulated",          &["units", "world"]),
    ("twin",              &["application", "canopen", "interface", "lcd", "position-sensor", "profiles", "shared-proto", "units", "world"]),
    ("bench",             &["emulated", "twin", "units", "world"]),
    // Tests and tools
    ("tests-fuzz",        &["canopen", "dev1", "object-dictionary", "shared-proto", "units"]),
    ("tests-host",        &["emulated", "units", "world"]),
    ("tests-qemu",        &["canopen", "object-dictionary", "positioning", "shared-proto", "units"]),
    ("perf-dev1",         &["canopen", "dev1", "object-dictionary", "units"]),
    ("perf-footprint",    &["perf-dev1"]),
    ("xtask",             &["object-dictionary", "profiles"]),
];

/// Packages that only firmware may use: hardware, interrupts, executors, clocks.
const HARDWARE: &[&str] =
    &["bxcan", "cortex-m", "defmt", "embassy-executor", "embassy-stm32", "embassy-time", "stm32"];

/// The logic: everything that firmware and bench are built from, and no more.
const LOGIC: &[&str] = &[
    "units",
    "object-dictionary",
    "shared-proto",
    "storage",
    "lcd",
    "positioning",
    "canopen",
    "profiles",
    "interface",
    "application",
];

/// Packages of the workspace, with what each of them uses outside of its tests.
fn packages() -> Vec<(String, Vec<String>)> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo writes JSON");
    let list = |value: &Value, name: &str| {
        value.get(name).and_then(Value::as_array).cloned().unwrap_or_default()
    };
    let name = |value: &Value| value["name"].as_str().unwrap_or_default().to_owned();
    list(&metadata, "packages")
        .iter()
        .map(|package| {
            let uses = list(package, "dependencies");
            let uses = uses.iter().filter(|dependency| dependency["kind"] != "dev").map(name);
            (name(package), uses.collect())
        })
        .collect()
}

#[test]
fn arrows_only_point_inwards() {
    let packages = packages();
    assert!(packages.len() > 10, "{packages:?}");
    let ours = |name: &str| packages.iter().any(|(package, _)| package == name);
    for (package, uses) in &packages {
        let (_, allowed) = MAY_KNOW
            .iter()
            .find(|(known, _)| known == package)
            .unwrap_or_else(|| panic!("{package} has no place in the layers"));
        for used in uses.iter().filter(|used| ours(used)) {
            assert!(allowed.contains(&used.as_str()), "{package} must not know {used}");
        }
    }
}

#[test]
fn logic_knows_no_hardware() {
    for (package, uses) in packages() {
        if LOGIC.contains(&package.as_str()) {
            let hardware = uses.iter().find(|used| HARDWARE.iter().any(|h| used.starts_with(h)));
            assert_eq!(hardware, None, "{package} is logic");
        }
    }
}
