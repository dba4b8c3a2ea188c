//! Active errors of other nodes, as a consumer of emergencies keeps them.

use async_canopen::emcy::machine::ActiveErrors;
use async_canopen::emcy::{ActiveError, Emergency, ErrorCode, ErrorRegister};

use crate::bench::node;

fn emergency(code: u16, register: u8, info: [u8; 5]) -> Emergency {
    Emergency { code: ErrorCode::new(code), register: ErrorRegister::from_bits(register), info }
}

/// Node-ID, code and source of each.
fn known(errors: &ActiveErrors) -> Vec<(u8, u16, u8)> {
    errors.iter().map(|ActiveError { node, code, source }| (node.get(), code.get(), source)).collect()
}

/// Verifies: ECSS 6.10m
/// Notices: ECSS 6.10m: an EMCY of one node clears the errors of another one.
#[test]
fn a_consumer_knows_the_active_errors_of_each_node() {
    let mut errors = ActiveErrors::default();
    assert!(errors.on_emergency(node(3), &emergency(0x4200, 0x09, [1, 0, 0, 0, 0])));
    assert!(errors.on_emergency(node(3), &emergency(0x8130, 0x19, [7, 0, 0, 0, 0])));
    assert!(errors.on_emergency(node(4), &emergency(0x4200, 0x09, [1, 0, 0, 0, 0])));
    assert!(errors.on_emergency(node(4), &emergency(0x8130, 0x19, [7, 0, 0, 0, 0])));
    // Twice is once.
    assert!(errors.on_emergency(node(3), &emergency(0x4200, 0x19, [1, 0, 0, 0, 0])));
    assert_eq!(known(&errors), [(3, 0x4200, 1), (3, 0x8130, 7), (4, 0x4200, 1), (4, 0x8130, 7)]);
    // The end of an error of another source, the end of a known one, and an error that is no longer in the register.
    errors.on_emergency(node(3), &emergency(0, 0x19, [0x30, 0x81, 6, 0, 0]));
    assert_eq!(known(&errors).len(), 4);
    errors.on_emergency(node(3), &emergency(0, 0x09, [0x30, 0x81, 7, 0, 0]));
    assert_eq!(known(&errors), [(3, 0x4200, 1), (4, 0x4200, 1), (4, 0x8130, 7)]);
    errors.on_emergency(node(3), &emergency(0x5000, 0x01, [0; 5]));
    assert_eq!(known(&errors), [(3, 0x5000, 0), (4, 0x4200, 1), (4, 0x8130, 7)]);
    // Another make: "no error" without a code, and a register without the generic bit.
    errors.on_emergency(node(5), &emergency(0x8120, 0x10, [0; 5]));
    assert_eq!(known(&errors).len(), 4);
    errors.on_emergency(node(5), &emergency(0, 0, [0; 5]));
    assert_eq!(known(&errors).len(), 3);
    errors.forget(node(4));
    assert_eq!(known(&errors), [(3, 0x5000, 0)]);
}

#[test]
fn a_register_that_is_not_explained_is_explained_by_the_history() {
    let mut errors = ActiveErrors::default();
    let register = ErrorRegister::from_bits;
    assert!(errors.on_register(node(3), register(0)));
    assert!(!errors.on_register(node(3), register(0x19)));
    // The newest first: one that is over, as its class is not in the register; then what explains it.
    assert!(!errors.on_history(node(3), register(0x19), 0x0000_3000));
    assert!(!errors.on_history(node(3), register(0x19), 0x0001_4200));
    assert!(!errors.on_history(node(3), register(0x19), 0x0002_4200), "the class is explained already");
    assert!(errors.on_history(node(3), register(0x19), 0x0007_8130));
    assert_eq!(known(&errors), [(3, 0x4200, 1), (3, 0x8130, 7)]);
    assert!(errors.on_register(node(3), register(0x19)));
    assert!(errors.on_register(node(3), register(0x11)), "one is over, the other one explains the rest");
    assert_eq!(known(&errors), [(3, 0x8130, 7)]);
    // The generic bit alone.
    assert!(!errors.on_register(node(4), register(0x01)));
    assert!(errors.on_history(node(4), register(0x01), 0x0000_5000));
    assert!(errors.on_register(node(4), register(0)));
    assert_eq!(known(&errors), [(3, 0x8130, 7)]);
}

#[test]
fn errors_without_a_place_are_counted() {
    let mut errors = ActiveErrors::default();
    for source in 0..64 {
        assert!(errors.on_emergency(node(3), &emergency(0x8130, 0x11, [source, 0, 0, 0, 0])));
    }
    assert!(!errors.on_emergency(node(4), &emergency(0x4200, 0x09, [0; 5])));
    assert_eq!((errors.lost(), errors.iter().count()), (1, 64));
    errors.on_emergency(node(3), &emergency(0, 0x11, [0x30, 0x81, 9, 0, 0]));
    assert!(errors.on_emergency(node(4), &emergency(0x4200, 0x09, [0; 5])));
    assert_eq!(errors.lost(), 1);
}
