//! Declarations that are refused, and what the compiler says then.

use syn::{DeriveInput, parse_quote};

use crate::{objects, record};

fn refused(expanded: syn::Result<proc_macro2::TokenStream>) -> String {
    expanded.unwrap_err().to_string()
}

/// The error of an object with this attribute, for a field of this type.
macro_rules! object {
    ($attribute:meta, $type:ty) => {{
        let input: DeriveInput = parse_quote! {
            struct Device {
                /// Value
                #[$attribute]
                value: $type,
            }
        };
        objects::expand(&input).map(drop).map_err(|error| error.to_string())
    }};
}

#[test]
fn an_access_right_is_needed() {
    let message = Err("missing access right: add `ro`, `wo`, `rw`, `rwr`, `rww` or `constant`".to_owned());
    assert_eq!(object!(object(0x2000), u8), message);
    assert_eq!(object!(object(0x2000, array), [u8; 2]), message);
    assert_eq!(object!(object(0x2000, pdo, low = 1), u8), message);
    assert_eq!(object!(object(0x2000, ro), u8), Ok(()));
    // The entries of a record have their own.
    assert_eq!(object!(object(0x2000, record), Channel), Ok(()));
}

#[test]
fn words_that_are_unknown_are_told_with_those_that_are_known() {
    let known =
        "ro, wo, rw, rwr, rww, constant, record, array, pdo, optional, keep, volatile, low, high, default";
    let message = |word| Err(format!("unknown word `{word}`; known are {known}"));
    assert_eq!(object!(object(0x2000, const_), u8), message("const_"));
    assert_eq!(object!(object(0x2000, rw, Pdo), u8), message("Pdo"));
    assert_eq!(object!(object(0x2000, rw pdo), u8), Err("a comma is missing".to_owned()));
}

#[test]
fn several_need_an_array() {
    assert_eq!(object!(object(0x2000.., ro), u8), Err("several in a row need an array".to_owned()));
    assert_eq!(object!(object(0x2000, array, ro), u8), Err("an ARRAY object needs an array".to_owned()));
    assert_eq!(
        object!(object(0x2000.., array, ro), [u8; 2]),
        Err("an ARRAY object needs an array".to_owned())
    );
    assert_eq!(object!(object(0x2000.., array, ro), [[u8; 2]; 3]), Ok(()));
}

/// Verifies: ECSS 6.8a
#[test]
fn an_index_has_sixteen_bits() {
    assert!(object!(object(0x1_0000, ro), u8).is_err());
    assert!(object!(object("2000h", ro), u8).is_err());
    assert_eq!(object!(object(0xFFFF, ro), u8), Ok(()));
}

/// Verifies: ECSS 6.6a
#[test]
fn every_value_has_a_title() {
    let message = "missing name: the first line of its documentation (`/// ..`) is its name in EDS and DCF";
    let without: DeriveInput = parse_quote! {
        struct Device {
            #[object(0x2000, ro)]
            value: u8,
        }
    };
    assert_eq!(refused(objects::expand(&without)), message);
    let empty: DeriveInput = parse_quote! {
        struct Channel {
            ///
            #[sub(1, ro)]
            value: u8,
        }
    };
    assert_eq!(refused(record::expand(&empty)), message);
}

/// Verifies: ECSS 6.8a
#[test]
fn an_index_and_a_sub_index_are_declared_once() {
    let device: DeriveInput = parse_quote! {
        struct Device {
            /// One
            #[object(0x2000, ro)]
            one: u8,
            /// Other
            #[object(0x2001, ro)]
            other: u8,
            /// Again
            #[object(0x2000, rw)]
            again: u8,
        }
    };
    assert_eq!(refused(objects::expand(&device)), "index 2000h is declared twice");
    let channel: DeriveInput = parse_quote! {
        struct Channel {
            /// One
            #[sub(1, ro)]
            one: u8,
            /// Again
            #[sub(1, rw)]
            again: u8,
        }
    };
    assert_eq!(refused(record::expand(&channel)), "sub-index 1 is declared twice");
}

#[test]
fn a_record_has_something_in_it() {
    let channel: DeriveInput = parse_quote! {
        struct Channel {
            #[skip]
            private: u8,
        }
    };
    assert_eq!(refused(record::expand(&channel)), "a record has at least one `#[sub(..)]`");
}

/// Verifies: ECSS 6.8a
#[test]
fn the_last_sub_index_is_254() {
    let with = |number: syn::LitInt| -> DeriveInput {
        parse_quote! {
            struct Channel {
                /// Value
                #[sub(#number, ro)]
                value: u8,
            }
        }
    };
    assert!(record::expand(&with(parse_quote!(254))).is_ok());
    for number in [parse_quote!(255), parse_quote!(256)] {
        assert_eq!(refused(record::expand(&with(number))), "a sub-index is at most 254");
    }
}

#[test]
fn a_declaration_knows_one_word_of_its_own() {
    let with = |attribute: syn::Attribute| -> DeriveInput {
        parse_quote! {
            #attribute
            struct Device {
                /// Value
                #[object(0x2000, rw)]
                value: u8,
            }
        }
    };
    let check = objects::expand(&with(parse_quote!(#[objects(check = limits::check)]))).unwrap().to_string();
    assert!(check.contains("limits :: check (self , at , value) ?"), "{check}");
    let without = objects::expand(&with(parse_quote!(#[derive(Debug)]))).unwrap().to_string();
    assert!(!without.contains("(self , at , value) ?"));
    for attribute in [parse_quote!(#[objects(verify = check)]), parse_quote!(#[objects(Check = check)])] {
        assert_eq!(
            refused(objects::expand(&with(attribute))),
            "unknown word; known are `check`, `device`, `sdo_servers` and `time`"
        );
    }
    // A function, by its path.
    for attribute in [parse_quote!(#[objects(check)]), parse_quote!(#[objects(check = 1)])] {
        assert!(objects::expand(&with(attribute)).is_err());
    }
}

#[test]
fn a_device_has_one_or_two_sdo_servers() {
    let with = |attribute: syn::Attribute| -> DeriveInput {
        parse_quote! {
            #attribute
            struct Device {}
        }
    };
    let texts = |attribute| -> Vec<String> {
        let errors = objects::expand(&with(attribute)).unwrap_err();
        errors.into_iter().map(|error| error.to_string()).collect()
    };
    for (number, sdo) in [
        (parse_quote!(1), "SdoServerObjects"),
        (parse_quote!(2), "TwoSdoServers"),
        (parse_quote!(0x2), "TwoSdoServers"),
    ] {
        let number: syn::LitInt = number;
        let expanded = objects::expand(&with(parse_quote!(#[objects(device, sdo_servers = #number)])));
        let expanded = expanded.unwrap().to_string();
        assert!(
            expanded.contains(&format!("type Sdo = :: async_canopen :: sdo :: {sdo} ;")),
            "{number}: {expanded}"
        );
    }
    for number in [parse_quote!(0), parse_quote!(3), parse_quote!(128)] {
        let number: syn::LitInt = number;
        let message = format!("a device has 1 or 2 SDO servers, not {number}");
        assert_eq!(texts(parse_quote!(#[objects(sdo_servers = #number, device)])), [message]);
    }
    let message = "`sdo_servers` is for a device: add `device`";
    assert_eq!(texts(parse_quote!(#[objects(sdo_servers = 2)])), [message]);
}

/// The tests of this crate do not depend on `ecss-can`.
#[test]
fn only_a_device_of_a_spacecraft_has_its_own_time() {
    let texts = |attribute: syn::Attribute| -> Vec<String> {
        let declaration = parse_quote! {
            #attribute
            struct Device {}
        };
        let errors = objects::expand(&declaration).unwrap_err();
        errors.into_iter().map(|error| error.to_string()).collect()
    };
    assert_eq!(texts(parse_quote!(#[objects(time)])), ["`time` is for a device: add `device`"]);
    let alone = "`time` is for a device of `ecss-can`, on which this package does not depend";
    assert_eq!(texts(parse_quote!(#[objects(device, time)])), [alone]);
}

#[test]
fn only_structs_with_names_can_be_declared() {
    let list: DeriveInput = parse_quote!(
        struct Device(u8);
    );
    assert_eq!(refused(objects::expand(&list)), "its values need names");
    let choice: DeriveInput = parse_quote!(
        enum Device {
            One,
        }
    );
    assert_eq!(refused(objects::expand(&choice)), "only a struct can be declared so");
    assert_eq!(refused(record::expand(&choice)), "only a struct can be declared so");
}

/// Given plain numbers that exclude each other, then that is an error of the declaration. Other expressions are left to the compiler.
#[test]
fn numbers_that_exclude_each_other_are_refused() {
    let swapped = Err("`low = 300` is above `high = 200`: no value is allowed".to_owned());
    assert_eq!(object!(object(0x2000, rw, low = 300, high = 200), u16), swapped);
    assert_eq!(object!(object(0x2000, rw, high = 0xC8, low = (300), default = 1), u16), swapped);
    let below = Err("`low = -1` is above `high = -2`: no value is allowed".to_owned());
    assert_eq!(object!(object(0x2000, rw, low = -1, high = -2), i8), below);
    let above = Err("default 101 is above `high = 100`".to_owned());
    assert_eq!(object!(object(0x2000, rw, low = 1, high = 100, default = 101), u8), above);
    let below = Err("default -41 is below `low = -40`".to_owned());
    assert_eq!(object!(object(0x2000, rw, low = -40, default = -41), i16), below);
    for attribute in [
        object!(object(0x2000, rw, low = 200, high = 200, default = 200), u16),
        object!(object(0x2000, rw, low = LOW, high = 200), u16),
        object!(object(0x2000, rw, low = 100 + 200, high = 200), u16),
        object!(object(0x2000, rw, default = -1), i16),
    ] {
        assert_eq!(attribute, Ok(()));
    }
}
