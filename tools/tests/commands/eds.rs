//! `eds` through the command line: its output, and a check that the files of the documentation are current.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::TOOLS;

/// Exit code, stdout and stderr.
fn eds(arguments: &[&str]) -> (i32, String, String) {
    TOOLS.run(&[&["eds"], arguments].concat())
}

/// Returns the folder of the files, below folders that are created.
fn folder(here: &TempDir) -> PathBuf {
    here.path().join("new/eds")
}

/// A temporary directory with the files that are written.
fn written(arguments: &[&str]) -> TempDir {
    let here = tempfile::tempdir().expect("a temporary directory");
    let (code, _, stderr) = eds(&[&["--out", folder(&here).to_str().unwrap()], arguments].concat());
    assert_eq!(code, 0, "{stderr}");
    here
}

fn read(here: &TempDir, name: &str) -> String {
    std::fs::read_to_string(folder(here).join(name)).expect(name)
}

fn names(here: &TempDir) -> Vec<String> {
    let entries = std::fs::read_dir(folder(here)).expect("a folder").map(|entry| entry.expect("an entry"));
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Verifies: ECSS 6.6a
/// Verifies: ECSS 9.2a
#[test]
fn the_committed_files_are_those_of_the_code() {
    let (code, _, stderr) = eds(&["--check"]);
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn a_stale_or_missing_file_is_named_and_left_alone() {
    let here = written(&[]);
    let check = || eds(&["--out", folder(&here).to_str().unwrap(), "--check"]);
    assert_eq!(check().0, 0);

    let path = folder(&here).join("slave-3.dcf");
    std::fs::write(&path, "changed").unwrap();
    let (code, _, complaint) = check();
    assert_eq!(code, 1);
    assert!(complaint.contains("slave-3.dcf") && complaint.contains("ecss-can eds"), "{complaint}");
    assert!(!complaint.contains("slave.eds"), "{complaint}");
    assert_eq!(read(&here, "slave-3.dcf"), "changed");

    std::fs::remove_file(&path).unwrap();
    assert_eq!(check().0, 1);
    assert!(!path.exists());
}

/// Given a profile with a minimal slave, then its DCF has only the objects of a minimal slave.
///
/// Verifies: ECSS 6.6a
#[test]
fn a_minimal_slave_gets_the_dcf_of_a_minimal_slave() {
    let here = written(&["--slave", "6", "--profile", "librecube"]);
    assert!(!folder(&here).join("slave-6.dcf").exists());
    let dcf = read(&here, "minimal-6.dcf");
    assert!(dcf.contains("NodeID=6") && dcf.contains("LastEDS=minimal-librecube.eds"), "{dcf}");
    assert!(!dcf.contains("[2000]") && !dcf.contains("[1200]"), "no redundancy parameters, no SDO server");
}

#[test]
fn a_dcf_for_older_tools_has_no_last_eds() {
    let usual = read(&written(&[]), "slave-3.dcf");
    let without = read(&written(&["--no-last-eds"]), "slave-3.dcf");
    assert_eq!(without, usual.replace("LastEDS=slave.eds\n", ""));
    assert_ne!(without, usual);
}

/// Given the DCF of all devices of a mission, then no two of them send one COB-ID. When one has the COB-ID of another, it is named.
///
/// Verifies: ECSS 6.10l, 6.10m
#[test]
fn a_cob_id_that_two_devices_send_is_found() {
    let here = written(&["--slave", "2", "--slave", "3", "--slave", "6"]);
    let path = |name: &str| folder(&here).join(name).display().to_string();
    let [master, two, three, six] = ["master.dcf", "slave-2.dcf", "slave-3.dcf", "minimal-6.dcf"].map(path);
    let (code, stdout, stderr) = eds(&["--check-network", &master, &two, &three, &six]);
    assert!(code == 0 && stdout.starts_with("4 devices send "), "{stdout}{stderr}");

    let text = read(&here, "slave-3.dcf");
    let own = "DefaultValue=$NODEID+0x40000380\n";
    assert!(text.contains(own));
    std::fs::write(&three, text.replace(own, &format!("{own}ParameterValue=0x40000382\n"))).unwrap();
    let (code, _, complaint) = eds(&["--check-network", &master, &two, &three, &six]);
    let said = format!("{two} (1802h) and {three} (1802h) send COB-ID 382h");
    assert!(code == 1 && complaint.contains(&said), "{complaint}");

    std::fs::write(&six, read(&here, "minimal-6.dcf").replace("NodeID=6", "NodeID=2")).unwrap();
    let (_, _, complaint) = eds(&["--check-network", &two, &six]);
    assert!(complaint.contains(&format!("{two} and {six} have Node-ID 2")), "{complaint}");
    let (code, _, complaint) = eds(&["--check-network", &path("slave.eds")]);
    assert!(code == 2 && complaint.contains("[DeviceComissioning] NodeID"), "{complaint}");
}

#[test]
fn every_slave_that_is_named_gets_its_dcf() {
    let here = written(&["--slave", "2", "--slave", "127", "--profile", "standard"]);
    let minimal = ["minimal-librecube.eds", "minimal.eds"];
    let slave = ["slave-127.dcf", "slave-2.dcf", "slave.eds"];
    assert_eq!(names(&here), [&["master.dcf", "master.eds"][..], &minimal, &slave].concat());
    let dcf = read(&here, "slave-127.dcf");
    assert!(dcf.contains("\nNodeID=127\n") && dcf.contains("profile standard\n"));
}

#[test]
fn bit_rates_are_those_that_the_clock_of_the_boards_can_make() {
    let text = read(&written(&[]), "slave.eds");
    let rates: Vec<&str> = text.lines().filter(|line| line.starts_with("BaudRate_")).collect();
    // 42 MHz is no multiple of 800 kHz.
    let can_make = |rate| format!("BaudRate_{rate}={}", u8::from(rate != 800));
    let expected = [10, 20, 50, 125, 250, 500, 800, 1000].map(can_make);
    assert_eq!(rates, expected);
}

/// The lines of a section, if it is there.
fn section<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(&format!("[{name}]\n"))?;
    Some(rest.split("\n[").next().unwrap())
}

/// From the standard's Tables 9-3 to 9-6, 9-8 and 9-12, not from the code: parameters and mapping of four PDOs each
/// way, that cannot be written and have no inhibit time (sub 3) and no event timer (sub 5); no NMT start-up, no SDO.
///
/// Verifies: ECSS 9.4.1d
/// Verifies: ECSS 9.4.4b
/// Verifies: ECSS 9.4.5a
/// Verifies: ECSS 9.4.10b
/// Verifies: ECSS 9.4.10e
#[test]
fn data_sheet_of_the_minimal_slave_is_that_of_clause_9() {
    let text = read(&written(&["--profile", "standard"]), "minimal.eds");
    let section = |name: &str| section(&text, name);
    let communication = (0..4).flat_map(|nth| [0x1400, 0x1600, 0x1800, 0x1A00].map(|first| first + nth));
    let mut expected: Vec<u32> =
        [0x1000, 0x1001, 0x1005, 0x1016, 0x1017, 0x1018].into_iter().chain(communication).collect();
    expected.sort_unstable();
    let there = (0x1000..0x2000).filter(|index| section(&format!("{index:04X}")).is_some());
    assert_eq!(there.collect::<Vec<u32>>(), expected);
    assert!(section("1005").unwrap().contains("DefaultValue=0x00000080"));
    for (nth, (receive, transmit)) in
        (0..).zip([(0x200, None), (0x300, Some(1)), (0x400, Some(254)), (0x500, Some(254))])
    {
        let parameters = |first: u32, sub| section(&format!("{:04X}sub{sub}", first + nth));
        let cob_id = format!("DefaultValue=$NODEID+0x{:08X}", 0x4000_0000 + receive);
        assert!(parameters(0x1400, 1).unwrap().contains(&cob_id), "{cob_id}");
        assert!(parameters(0x1400, 2).unwrap().contains("DefaultValue=0xFE"));
        if let Some(transmission) = transmit {
            let cob_id = format!("DefaultValue=$NODEID+0x{:08X}", 0x4000_0180 + 0x100 * nth);
            assert!(parameters(0x1800, 1).unwrap().contains(&cob_id), "{cob_id}");
            assert!(parameters(0x1800, 2).unwrap().contains(&format!("DefaultValue=0x{transmission:02X}")));
        }
        for first in [0x1400, 0x1800] {
            assert!([3, 4, 5, 6].iter().all(|sub| parameters(first, *sub).is_none()));
        }
        for first in [0x1600, 0x1A00] {
            let mapping = (0..=8).map(|sub| parameters(first, sub).unwrap());
            assert!(mapping.into_iter().all(|entry| entry.contains("AccessType=ro")), "{first:04X}");
        }
    }
    for entry in ["SimpleBootUpSlave=0", "NrOfRXPDO=4", "NrOfTXPDO=4"] {
        assert!(text.contains(entry), "{entry}");
    }
}

/// A data sheet of a minimal slave has no object that Table 9-12 forbids or allows only for tests.
///
/// Verifies: ECSS 9.4.10c, 9.4.10d, 9.4.10f
#[test]
fn data_sheets_of_minimal_slaves_have_no_forbidden_object() {
    let here = written(&[]);
    let forbidden = [0x1007, 0x100C, 0x100D].into_iter().chain(0x1010..=0x1015).chain(0x1200..=0x12FF);
    let pdos = [0x1404, 0x1604, 0x1804, 0x1A04].map(|first| first..first + 0x1FC);
    let forbidden: Vec<u32> = forbidden.chain(pdos.into_iter().flatten()).collect();
    for name in ["minimal.eds", "minimal-librecube.eds"] {
        let text = read(&here, name);
        assert!(section(&text, "1000").is_some() && section(&text, "1A03").is_some(), "{name}");
        let there = forbidden.iter().filter(|index| section(&text, &format!("{index:04X}")).is_some());
        assert_eq!(there.collect::<Vec<_>>(), Vec::<&u32>::new(), "{name}");
    }
}

/// In profile `librecube` RPDO 1 is the Spacecraft Time PDO and TPDO 1 the Local Time PDO: fine time, then coarse time (ECSS Figure 7-1).
///
/// Verifies: ECSS 7.1.2a, 7.1.2b, 7.1.2f
#[test]
fn data_sheet_of_the_prototype_has_the_time() {
    let text = read(&written(&[]), "minimal-librecube.eds");
    let default = |name: &str| {
        let lines = section(&text, name).unwrap_or_else(|| panic!("no {name}")).lines();
        lines.filter_map(|line| line.strip_prefix("DefaultValue=")).collect::<Vec<_>>().concat()
    };
    for (entry, value) in [
        ("1400sub1", "0x40000181"),
        ("1401sub1", "$NODEID+0x40000300"),
        ("1402sub1", "$NODEID+0x40000400"),
        ("1600sub1", "0x20100218"),
        ("1600sub2", "0x20100120"),
        ("1800sub1", "$NODEID+0x40000180"),
        ("1800sub2", "0x01"),
        ("1A00sub1", "0x20110218"),
        ("1A00sub2", "0x20110120"),
        ("1A02sub1", "0x61000110"),
        ("1A02sub2", "0x61000230"),
    ] {
        assert_eq!(default(entry), value, "{entry}");
    }
}

#[test]
fn a_node_that_is_no_slave_is_refused() {
    for node in ["0", "1", "128"] {
        TOOLS.refuses(&["eds", "--slave", node], &["2..=127"]);
    }
}

/// The example's program on the host prints them; `--package` writes them.
#[test]
fn a_package_of_the_user_gets_its_files() {
    let here = written(&["--package", "thermometer", "--slave", "5"]);
    assert_eq!(names(&here), ["thermometer-5.dcf", "thermometer.eds"]);
    assert!(read(&here, "thermometer.eds").contains("ParameterName=Calibration table"));
    assert!(read(&here, "thermometer-5.dcf").contains("NodeID=5"));
}

#[test]
fn a_package_without_data_sheet_or_manifest_is_refused() {
    let without_manifest = ["--package", "thermometer", "--manifest-path", "nowhere/Cargo.toml"];
    for (arguments, parts) in [
        (&["--package", "slave"][..], &["slave printed no data sheet", "ecss_can_eds::slave_program"][..]),
        (&without_manifest, &["nowhere/Cargo.toml: no such file"]),
    ] {
        let (code, _, complaint) = eds(arguments);
        assert_eq!(code, 1, "{arguments:?}");
        assert!(parts.iter().all(|part| complaint.contains(part)), "{arguments:?}: {complaint}");
    }
}

/// Given a text in place of a data sheet, then no flight or comparison takes place, the exit code is 2, and the error
/// describes such a file.
#[test]
fn text_in_place_of_a_data_sheet_is_refused() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("notes.eds");
    std::fs::write(&file, "# Heater\n\nvoltage = 5 V\n").unwrap();
    let file = file.to_str().unwrap();
    for arguments in [&["fly", "--eds", &format!("2={file}")][..], &["eds", "--check-network", file]] {
        TOOLS.refuses(arguments, &["notes.eds", "no EDS or DCF (CiA 306)", "[DeviceInfo]"]);
    }
}
