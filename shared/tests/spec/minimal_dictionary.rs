//! PDOs and objects that a minimal slave may have (ECSS 9.4, Table 9-12).

use ecss_can::node::minimal::{
    MinimalPdos, MinimalRpdo, MinimalTpdo, PDOS, Permission, Trigger, assert_minimal, permission,
};
use ecss_can::pdo::CobIdOf;

use crate::bench::node;

/// Given slaves with the lowest, a middle and the highest Node-ID, then their COB-IDs are those of Tables 9-4 and 9-6.
///
/// Verifies: ECSS 9.4.2d, 9.4.4c, 9.4.4d, 9.3a
/// Notices: ECSS 9.4.2d: COB-IDs have the low six bits of the Node-ID.
/// Notices: ECSS 9.4.4c: TPDO 4 has COB-ID 500h + node.
/// Notices: ECSS 9.4.4d: telemetry on request has transmission type 255.
#[test]
fn its_pdos_are_those_of_the_tables() {
    let pdos = MinimalPdos::DEFAULT;
    for (id, received, sent) in [
        (2, [0x202, 0x302, 0x402, 0x502], [0x182, 0x282, 0x382, 0x482]),
        (5, [0x205, 0x305, 0x405, 0x505], [0x185, 0x285, 0x385, 0x485]),
        (126, [0x27E, 0x37E, 0x47E, 0x57E], [0x1FE, 0x2FE, 0x3FE, 0x4FE]),
    ] {
        let receive = pdos.receive.map(|pdo| pdo.map(|pdo| (pdo.cob_id.of(node(id)).raw(), pdo.least)));
        assert_eq!(receive, received.map(|id| Some((id, 0))));
        let transmit = pdos.transmit.map(|pdo| pdo.unwrap());
        let transmit = transmit.map(|pdo| (pdo.cob_id.of(node(id)).raw(), pdo.trigger.transmission_type()));
        assert_eq!(transmit, sent.map(|id| (id, 254)));
    }
    assert_eq!(Trigger::Sync(3).transmission_type(), 3);
    pdos.assert_possible();
}

/// Verifies: ECSS 6.2a
/// Notices: ECSS 6.2a: a TPDO may go with every 241st SYNC.
#[test]
fn pdos_that_cannot_be_are_refused() {
    let rpdo = |base| Some(MinimalRpdo { cob_id: CobIdOf::node(base), least: 0 });
    let tpdo = |base, trigger| Some(MinimalTpdo { cob_id: CobIdOf::node(base), trigger });
    let sync = |every| MinimalPdos {
        receive: [None; PDOS],
        transmit: [tpdo(0x180, Trigger::Sync(every)), None, None, None],
    };
    let receiving = |receive| MinimalPdos { receive, transmit: [None; PDOS] };
    let twice = receiving([rpdo(0x200), None, None, rpdo(0x200)]);
    let sent = [None, tpdo(0x280, Trigger::Request), tpdo(0x280, Trigger::Sync(1)), None];
    let sent = MinimalPdos { receive: [None; PDOS], transmit: sent };
    let long = MinimalRpdo { cob_id: CobIdOf::node(0x200), least: 9 };
    let long = receiving([Some(long), None, None, None]);
    for (pdos, reason) in [
        (sync(0), "every 1 to 240 SYNCs"),
        (sync(241), "every 1 to 240 SYNCs"),
        (twice, "two PDOs have one COB-ID"),
        (sent, "two PDOs have one COB-ID"),
        (long, "a PDO has 8 bytes at most"),
    ] {
        let panic = std::panic::catch_unwind(|| pdos.assert_possible()).unwrap_err();
        assert_eq!(panic.downcast_ref::<&str>(), Some(&reason));
    }
    sync(240).assert_possible();
}

/// Each row of Table 9-12, by its first and last index, and what is beside it.
///
/// Verifies: ECSS 9.4.10b, 9.4.10c
/// Notices: ECSS 9.4.10b: 1014h and 1015h are authorised.
/// Notices: ECSS 9.4.10c: the last object of a forbidden range is authorised.
#[test]
fn forbidden_objects_are_those_of_the_table() {
    let is = |index, expected| assert_eq!(permission(index), expected, "{index:04X}h");
    for index in [0x1000, 0x1003, 0x1005, 0x1006, 0x1008, 0x100A, 0x1016, 0x1018, 0x1019, 0x1028, 0x6000] {
        is(index, Permission::Authorised);
    }
    for index in [0x1007, 0x100C, 0x100D, 0x1010, 0x1011, 0x1012, 0x1013, 0x1014, 0x1015] {
        is(index, Permission::Forbidden);
    }
    for index in [0x1201, 0x127F, 0x1281, 0x12FF] {
        is(index, Permission::Forbidden);
    }
    is(0x1200, Permission::Tests);
    is(0x1280, Permission::Tests);
    for (first, last) in [(0x1400, 0x15FF), (0x1600, 0x17FF), (0x1800, 0x19FF), (0x1A00, 0x1BFF)] {
        is(first, Permission::Authorised);
        is(first + 3, Permission::Authorised);
        is(first + 4, Permission::Forbidden);
        is(last, Permission::Forbidden);
    }
}

/// Parameters and mapping of RPDO 1, with an object more or less, or one that must not be as it is.
mod dictionaries {
    use super::*;
    use ecss_can::od::{Objects, Record};
    use ecss_can::pdo::{PdoMapping, StaticMapping};

    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Fixed {
        /// COB-ID
        #[sub(1, ro)]
        cob_id: u32,
        /// Transmission type
        #[sub(2, ro)]
        transmission: u8,
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Inhibited {
        /// COB-ID
        #[sub(1, ro)]
        cob_id: u32,
        /// Inhibit time
        #[sub(3, ro)]
        inhibit: u16,
    }

    #[derive(Debug, Objects)]
    pub struct Sound {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
    }

    #[derive(Debug, Objects)]
    pub struct Unmapped {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Repeated {
        /// COB-ID
        #[sub(1, ro)]
        cob_id: u32,
        /// Event timer
        #[sub(5, ro)]
        event: u16,
    }

    #[derive(Debug, Objects)]
    pub struct Timed {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Inhibited,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
    }

    #[derive(Debug, Objects)]
    pub struct RepeatedCommand {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Repeated,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
    }

    /// RPDO 1, and TPDO 4 with an inhibit time.
    #[derive(Debug, Objects)]
    pub struct InhibitedTelemetry {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
        /// Parameters
        #[object(0x1803, record)]
        telemetry: Inhibited,
    }

    /// RPDO 1, and TPDO 4 with an event timer.
    #[derive(Debug, Objects)]
    pub struct RepeatedTelemetry {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
        /// Parameters
        #[object(0x1803, record)]
        telemetry: Repeated,
    }

    #[derive(Debug, Objects)]
    pub struct Variable {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, rw)]
        mapping: [u32; 1],
    }

    /// Mapping whose number of objects can be written.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Counted {
        /// Number of mapped objects
        #[sub(0, rw, high = 1)]
        count: u8,
        /// Mapped object
        #[sub(1, ro)]
        object: u32,
    }

    #[derive(Debug, Objects)]
    pub struct Emptied {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, record)]
        mapping: Counted,
    }

    /// Mapping of which the last object can be written.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Long {
        /// Mapped object
        #[sub(1, ro)]
        first: u32,
        /// Mapped object 64
        #[sub(64, rw)]
        last: u32,
    }

    #[derive(Debug, Objects)]
    pub struct LastMapped {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, record)]
        mapping: Long,
    }

    #[derive(Debug, Objects)]
    pub struct EmcyInhibited {
        /// Inhibit time of EMCY
        #[object(0x1015, ro)]
        inhibit: u16,
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
    }

    #[derive(Debug, Objects)]
    pub struct LastTpdo {
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
        /// Mapping of TPDO 512
        #[object(0x1BFF, array, ro)]
        last: [u32; 1],
    }

    #[derive(Debug, Objects)]
    pub struct Stored {
        /// Store parameters
        #[object(0x1010, ro)]
        store: u32,
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
    }

    /// A mapping without parameters.
    #[derive(Debug, Objects)]
    pub struct Unparametrised {
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
    }

    /// A synchronous window of 20 ms.
    #[derive(Debug, Objects)]
    pub struct Windowed {
        /// Synchronous window length
        #[object(0x1007, ro, default = 20_000)]
        window: u32,
        /// Parameters
        #[object(0x1400, record)]
        pdo: Fixed,
        /// Mapping
        #[object(0x1600, array, ro)]
        mapping: [u32; 1],
    }

    /// COB-ID that can be written.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Moved {
        /// COB-ID
        #[sub(1, rw)]
        cob_id: u32,
        /// Transmission type
        #[sub(2, ro)]
        transmission: u8,
    }

    /// Transmission type that can be written.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Retyped {
        /// COB-ID
        #[sub(1, ro)]
        cob_id: u32,
        /// Transmission type
        #[sub(2, rw)]
        transmission: u8,
    }

    /// Parameters without a transmission type.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
    pub struct Untyped {
        /// COB-ID
        #[sub(1, ro)]
        cob_id: u32,
    }

    /// RPDO 1 and TPDO 4 with these parameters.
    macro_rules! parametrised {
        ($name:ident, $command:ty, $telemetry:ty) => {
            #[derive(Debug, Objects)]
            pub struct $name {
                /// Parameters
                #[object(0x1400, record)]
                pdo: $command,
                /// Mapping
                #[object(0x1600, array, ro)]
                mapping: [u32; 1],
                /// Parameters
                #[object(0x1803, record)]
                telemetry: $telemetry,
                /// Mapping
                #[object(0x1A03, array, ro)]
                telemetry_mapping: [u32; 1],
            }
        };
    }
    parametrised!(BothFixed, Fixed, Fixed);
    parametrised!(CommandMoved, Moved, Fixed);
    parametrised!(CommandRetyped, Retyped, Fixed);
    parametrised!(CommandUntyped, Untyped, Fixed);
    parametrised!(TelemetryMoved, Fixed, Moved);
    parametrised!(TelemetryRetyped, Fixed, Retyped);
    parametrised!(TelemetryUntyped, Fixed, Untyped);

    /// RPDO 1 with this mapping and TPDO 4 with that one.
    macro_rules! mapped {
        ($name:ident, $command:ty, $telemetry:ty) => {
            #[derive(Debug, Objects)]
            pub struct $name {
                /// Parameters
                #[object(0x1400, record)]
                pdo: Fixed,
                /// Mapping
                #[object(0x1600, record)]
                mapping: $command,
                /// Parameters
                #[object(0x1803, record)]
                telemetry: Fixed,
                /// Mapping
                #[object(0x1A03, record)]
                telemetry_mapping: $telemetry,
            }
        };
    }
    mapped!(BothStatic, StaticMapping, StaticMapping);
    mapped!(CommandRemapped, PdoMapping, StaticMapping);
    mapped!(TelemetryRemapped, StaticMapping, PdoMapping);

    /// What is said of a dictionary with RPDO 1 and one of these objects.
    macro_rules! refusals {
        ($($index:literal)*) => {
            vec![$({
                #[derive(Debug, Objects)]
                struct With {
                    /// Parameters
                    #[object(0x1400, record)]
                    pdo: Fixed,
                    /// Mapping
                    #[object(0x1600, array, ro)]
                    mapping: [u32; 1],
                    /// Forbidden
                    #[object($index, ro)]
                    forbidden: u32,
                }
                ($index, refusal::<With>())
            }),*]
        };
    }

    /// Objects of every range of the table.
    pub fn forbidden() -> Vec<(u16, Option<String>)> {
        refusals![
            0x1007 0x100C 0x100D 0x1010 0x1011 0x1012 0x1013 0x1014 0x1015 0x1200 0x1201 0x1240 0x127F 0x1280 0x1281 0x12C0
            0x12FF 0x1404 0x1500 0x15FF 0x1604 0x1701 0x17FF 0x1804 0x1900 0x19FF 0x1A04 0x1B01 0x1BFF
        ]
    }

    /// As in a constant, where a panic stops the build.
    pub fn refusal<D: Objects>() -> Option<String> {
        refusal_with::<D>([None; PDOS])
    }

    /// The same with telemetry.
    pub fn refusal_with<D: Objects>(transmit: [Option<MinimalTpdo>; PDOS]) -> Option<String> {
        let rpdo = Some(MinimalRpdo { cob_id: CobIdOf::node(0x200), least: 0 });
        let pdos = MinimalPdos { receive: [rpdo, None, None, None], transmit };
        let panic = std::panic::catch_unwind(|| assert_minimal::<D>(&pdos)).err()?;
        panic.downcast_ref::<&str>().map(|reason| (*reason).to_owned())
    }
}

/// Verifies: ECSS 9.4.5a, 9.4.10b, 9.4.10d, 9.4.10e, 9.4.1d
/// Notices: ECSS 9.4.5a: only sub-index 0 of a mapping is checked for access.
/// Notices: ECSS 9.4.5a: sub-index 0 of a mapping is not checked for access.
/// Notices: ECSS 9.4.10d: a forbidden object without sub-indices, such as 1007h, may have a value.
/// Notices: ECSS 9.4.10e: parameters without a mapping are enough for a PDO.
/// Notices: ECSS 9.4.10e: a mapping without parameters is enough for a PDO.
/// Notices: ECSS 9.4.5a: the access of a mapped object above the eighth is not checked.
#[test]
fn dictionaries_that_the_minimal_set_forbids_are_refused() {
    use dictionaries::{
        Emptied, LastMapped, Sound, Stored, Timed, Unmapped, Unparametrised, Variable, Windowed, refusal,
    };
    assert_eq!(refusal::<Sound>(), None);
    for (refusal, reason) in [
        (refusal::<Unmapped>(), "a PDO in use without its parameters or its mapping"),
        (refusal::<Unparametrised>(), "a PDO in use without its parameters or its mapping"),
        (refusal::<Timed>(), "a PDO with an inhibit time or an event timer"),
        (refusal::<Variable>(), "a mapping that can be written"),
        (refusal::<Emptied>(), "a mapping that can be written"),
        (refusal::<LastMapped>(), "a mapping that can be written"),
        (refusal::<Stored>(), "an object that Table 9-12 of the standard does not authorise"),
        (refusal::<Windowed>(), "an object that Table 9-12 of the standard does not authorise"),
    ] {
        assert_eq!(refusal.as_deref(), Some(reason));
    }
}

/// Given a dictionary with RPDO 1 and TPDO 4, when a client can write the mapping of one of them, then it is refused. TPDO 4 may be in use
/// or not.
///
/// Verifies: ECSS 9.4.5a
/// Notices: ECSS 9.4.5a: the access of the mapping of a TPDO is not checked.
#[test]
fn mapping_of_either_direction_that_can_be_written_is_refused() {
    use dictionaries::{BothStatic, CommandRemapped, TelemetryRemapped, refusal_with};
    for telemetry in [None, MinimalPdos::DEFAULT.transmit[3]] {
        let transmit = [None, None, None, telemetry];
        assert_eq!(refusal_with::<BothStatic>(transmit), None);
        let reason = Some("a mapping that can be written");
        assert_eq!(refusal_with::<CommandRemapped>(transmit).as_deref(), reason);
        assert_eq!(refusal_with::<TelemetryRemapped>(transmit).as_deref(), reason);
    }
}

/// Given dictionaries with the first, the last or the only object (1007h) of a range that Table 9-12 forbids, then none is accepted.
///
/// Verifies: ECSS 9.4.7.3d, 9.4.10b, 9.4.10c, 9.4.10d
/// Notices: ECSS 9.4.7.3d: a range of a single object is not checked: 1007h may exist.
/// Notices: ECSS 9.4.10c: the first object of a forbidden range, such as 1010h, may exist.
/// Notices: ECSS 9.4.10b: the last object of a forbidden range, such as 1015h, may exist.
/// Notices: ECSS 9.4.10c: the last object of a forbidden range, such as 1015h, may exist.
/// Notices: ECSS 9.4.10d: the last object of a forbidden range, such as 1015h, may exist.
#[test]
fn first_and_last_object_of_a_forbidden_range_are_refused() {
    use dictionaries::{EmcyInhibited, LastTpdo, Stored, Windowed, refusal};
    let reason = "an object that Table 9-12 of the standard does not authorise";
    for refusal in
        [refusal::<Stored>(), refusal::<EmcyInhibited>(), refusal::<LastTpdo>(), refusal::<Windowed>()]
    {
        assert_eq!(refusal.as_deref(), Some(reason));
    }
}

/// Given a dictionary with one object of a range that Table 9-12 forbids, or has for tests alone, then it is refused, whichever it is.
///
/// Verifies: ECSS 9.4.10b, 9.4.10c, 9.4.10d
/// Notices: ECSS 9.4.10d: of a forbidden range only the ends are checked: 1012h may have a value.
/// Notices: ECSS 9.4.10d: the last range, 1A04h to 1BFFh, is not checked.
#[test]
fn each_object_of_a_forbidden_range_is_refused() {
    let reason = "an object that Table 9-12 of the standard does not authorise";
    for (index, refusal) in dictionaries::forbidden() {
        assert_eq!(refusal.as_deref(), Some(reason), "{index:04X}h");
    }
}

/// Given telemetry by the first or the last TPDO in a dictionary that has RPDO 1 alone, then it is refused.
///
/// Verifies: ECSS 9.4.10e
#[test]
fn telemetry_without_parameters_is_refused() {
    use dictionaries::{Sound, refusal_with};
    let tpdo = MinimalPdos::DEFAULT.transmit[0];
    for transmit in [[tpdo, None, None, None], [None, None, None, tpdo]] {
        let reason = "a PDO in use without its parameters or its mapping";
        assert_eq!(refusal_with::<Sound>(transmit).as_deref(), Some(reason));
    }
}

/// Given dictionaries with an inhibit time (sub-index 3) or an event timer (5) of a command or of telemetry, then none is accepted.
///
/// Verifies: ECSS 9.4.1d, 9.4.4b
/// Notices: ECSS 9.4.4b: sub-index 6 is checked in place of the event timer.
#[test]
fn inhibit_time_and_event_timer_are_refused_for_each_pdo() {
    use dictionaries::{InhibitedTelemetry, RepeatedCommand, RepeatedTelemetry, Timed, refusal};
    let reason = "a PDO with an inhibit time or an event timer";
    for refusal in [
        refusal::<Timed>(),
        refusal::<RepeatedCommand>(),
        refusal::<InhibitedTelemetry>(),
        refusal::<RepeatedTelemetry>(),
    ] {
        assert_eq!(refusal.as_deref(), Some(reason));
    }
}

/// Given dictionaries with a COB-ID or a transmission type of a command or of telemetry that can be written, or without a transmission
/// type, then none is accepted. Tables 9-4 and 9-6 have both, and both are `ro`.
///
/// Verifies: ECSS 9.4.2d, 9.4.4c, 9.4.10e
/// Notices: ECSS 9.4.2d: sub-index 2 of a PDO may be written.
/// Notices: ECSS 9.4.4c: the COB-ID of telemetry may be written.
/// Notices: ECSS 9.4.10e: a PDO without a transmission type is accepted.
#[test]
fn pdo_parameters_that_can_be_written_are_refused() {
    use dictionaries::{
        BothFixed, CommandMoved, CommandRetyped, CommandUntyped, TelemetryMoved, TelemetryRetyped,
        TelemetryUntyped, refusal_with,
    };
    let transmit = [None, None, None, MinimalPdos::DEFAULT.transmit[3]];
    assert_eq!(refusal_with::<BothFixed>(transmit), None);
    let reason = "a PDO whose COB-ID or transmission type is missing or can be written";
    for refusal in [
        refusal_with::<CommandMoved>(transmit),
        refusal_with::<CommandRetyped>(transmit),
        refusal_with::<CommandUntyped>(transmit),
        refusal_with::<TelemetryMoved>(transmit),
        refusal_with::<TelemetryRetyped>(transmit),
        refusal_with::<TelemetryUntyped>(transmit),
    ] {
        assert_eq!(refusal.as_deref(), Some(reason));
    }
}
