//! Each script with its spacecraft. Profile `standard` has short periods, `librecube` long timeouts.

use second::script;

/// Runs a script, and returns the output of the spacecraft.
fn passes(name: &str, arguments: &[&str]) -> String {
    script::run(name, arguments).unwrap_or_else(|failure| panic!("{failure:#}"))
}

/// Runs a script with test devices as these nodes.
fn passes_with_device(name: &str, arguments: &[&str], nodes: &[u8]) {
    script::run_with_device(name, arguments, nodes).unwrap_or_else(|failure| panic!("{failure:#}"));
}

/// Given an undisturbed spacecraft, then heartbeats, boot-up and SYNC are as expected.
///
/// Verifies: ECSS 6.5.2a, 6.9c, 8.3.3a
#[test]
fn a_spacecraft_left_alone_is_heard_as_it_should_be() {
    passes("listening.py", &["--profile", "standard", "--slaves", "3"]);
}

/// Given boards with 125 kbit/s, when python-can attaches with this bit rate, then it sees every frame. When it attaches with 1 Mbit/s,
/// then it hears nothing, and both bit rates are named.
///
/// Verifies: ECSS 5.4.2a.3
#[test]
fn python_can_sees_every_frame_at_125_kbit_per_second() {
    let said = script::run_at_125_kbit("slow_bus.py").unwrap_or_else(|failure| panic!("{failure:#}"));
    let named = ["nominal", "redundant"].map(|bus| format!("{bus} bus: slcan socket://127.0.0.1:"));
    let rated =
        |start: &String| said.lines().any(|line| line.starts_with(start) && line.contains(" at 125 kbit/s"));
    assert!(named.iter().all(rated), "{said}");
    assert!(said.contains("cannot be opened with 1000 kbit/s, the bus has 125 kbit/s"), "{said}");
}

/// Given the canopen package as the master, then slaves obey it.
///
/// Verifies: ECSS 6.5.1a, 6.5.4a
#[test]
fn slaves_obey_a_foreign_nmt_master() {
    passes("nmt.py", &["--profile", "librecube", "--slaves", "2", "--no-master"]);
}

/// Given telecommands and requests on PDOs, then they are executed and answered. A short PDO causes an emergency.
#[test]
fn telecommands_are_executed_and_telemetry_answers() {
    passes("telemetry.py", &["--profile", "librecube", "--slaves", "2", "--no-master"]);
}

/// Given expedited, segmented and block transfers of up to 20 kB, then values are transferred, and errors are aborted.
#[test]
fn values_of_every_type_and_20_kilobytes_are_moved_over_sdo() {
    passes_with_device("sdo.py", &["--profile", "librecube", "--slaves", "0", "--no-master"], &[2, 3]);
}

/// Given the committed DCF of a slave, then each object is read and written.
#[test]
fn every_object_of_a_slave_is_read_and_written_over_sdo() {
    passes("slave_objects.py", &["--profile", "librecube", "--slaves", "2", "--no-master"]);
}

/// Given a test device with values of every type, then each object is read and written.
#[test]
fn every_object_of_a_test_device_is_read_and_written_over_sdo() {
    passes_with_device("slave_objects.py", &["--profile", "librecube", "--slaves", "1", "--no-master"], &[3]);
}

/// Given the committed EDS of a master that commands slaves, then each object is read and written.
#[test]
fn every_object_of_the_master_is_read_and_written_over_sdo() {
    passes("master_objects.py", &["--profile", "librecube", "--slaves", "3"]);
}

/// Given the bits in the data sheet of a slave, then times are decoded (Figure 7-1).
///
/// Verifies: ECSS 7.1.2f, 7.2.3b, 7.2.3g, 7.2.3h, 7.2.3i
#[test]
fn times_are_decoded_from_their_pdos() {
    passes("time_pdos.py", &["--profile", "standard", "--slaves", "3"]);
}

/// Given the bits in the data sheet of a slave, then UTC is decoded (Figure 7-2).
///
/// Verifies: ECSS 7.1.3e, 7.2.2b, 7.2.3i
#[test]
fn utc_is_decoded_from_its_pdos() {
    passes_with_device("utc_pdos.py", &["--profile", "librecube", "--slaves", "1", "--no-master"], &[3]);
}

/// Given the names in the data sheet, then PDOs are subscribed, and a mapping is changed.
#[test]
fn pdos_are_subscribed_and_mapped_anew() {
    passes_with_device("pdo.py", &["--profile", "librecube", "--slaves", "1", "--no-master"], &[3]);
}

/// Given a slave, then its services, objects and identifiers follow each rule of CiA 301, checked by frames only.
///
/// Verifies: ECSS 6.1a, 6.2a, 6.5.4a, 6.10b
#[test]
fn a_slave_keeps_the_rules_of_cia_301() {
    passes_with_device("conformance.py", &["--profile", "librecube", "--slaves", "0", "--no-master"], &[3]);
}

/// Given a DCF, then it is loaded over SDO.
#[test]
fn a_slave_takes_its_dcf() {
    passes_with_device("configuration.py", &["--profile", "librecube", "--slaves", "1", "--no-master"], &[3]);
}

/// Given the example of a user's device, then the data sheet that its program prints describes it.
#[test]
fn a_thermometer_is_known_by_its_own_data_sheet() {
    script::run_with_thermometer().unwrap_or_else(|failure| panic!("{failure:#}"));
}

/// Runs a script with an example slave on one bus, on the CAN driver of embassy-stm32.
fn passes_with_plain_slave(name: &str, program: &str) {
    script::run_with_embassy(name, program).unwrap_or_else(|failure| panic!("{program}: {failure:#}"));
}

/// The example slaves on the CAN driver of embassy-stm32: all of it, and as a driver of `embedded_can::nb`. Commands by SLCAN, names
/// by the data sheet.
#[test]
fn slaves_on_embassys_driver_obey_the_canopen_package() {
    for program in ["bxcan-slave", "nonblocking-slave"] {
        passes_with_plain_slave("embassy.py", program);
    }
}

/// Given the DCF of async-canopen only, then each object is read and written.
#[test]
fn every_object_of_a_plain_slave_is_read_and_written_over_sdo() {
    passes_with_plain_slave("plain_objects.py", "bxcan-slave");
}

/// The cases of `a_slave_keeps_the_rules_of_cia_301` that apply to a slave on one bus. `conformance_devices.py` lists the others.
#[test]
fn a_plain_slave_keeps_the_rules_of_cia_301() {
    passes_with_plain_slave("conformance.py", "bxcan-slave");
}

/// Given a slave on `embedded_can::nb` and requests at the highest rate, then the cases hold too, and no request is
/// lost.
#[test]
fn a_plain_slave_on_embedded_can_keeps_the_rules_of_cia_301() {
    passes_with_plain_slave("conformance.py", "nonblocking-slave");
}

/// 1010h and 1011h.
#[test]
fn parameters_are_stored_and_restored() {
    passes("storing.py", &["--profile", "librecube", "--slaves", "2", "--no-master"]);
}

/// Given foreign commands, then the master follows none, and starts a slave that was set to another state.
#[test]
fn the_master_brings_slaves_back() {
    passes("master.py", &["--profile", "standard", "--slaves", "2"]);
}

/// Given a slave of the canopen package, then the master and a slave consume its heartbeats and emergencies.
///
/// Verifies: ECSS 6.4a.2, 6.5.2a
#[test]
fn heartbeats_and_emergencies_of_a_foreign_slave_are_consumed() {
    let said = passes("emergencies.py", &["--profile", "standard", "--slaves", "2"]);
    let emergencies = said.lines().filter_map(|line| Some(line.split_once("slave 9: EMCY ")?.1));
    let heard = [
        "5530h, error register 81h, [66, 6C, 61, 73, 68]",
        "4210h, error register 09h, [00, 01, 7F, 80, FF]",
        "FF01h, error register 01h, [00, 00, 00, 00, 00]",
        "0000h, error register 00h, [00, 00, 00, 00, 00]",
    ];
    assert_eq!(emergencies.collect::<Vec<_>>(), heard);
}

/// Given a spacecraft that leaves a bus during a transfer, then transfers continue on the other one, and after its
/// return.
///
/// Verifies: ECSS 8.3.3b
#[test]
fn transfers_go_on_on_the_other_bus() {
    passes_with_device("failover.py", &["--profile", "librecube", "--slaves", "0"], &[2, 3]);
}
