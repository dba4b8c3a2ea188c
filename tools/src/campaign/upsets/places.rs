//! Places in the memories of a board: sections, variables, stack, program, parameter store.

use std::ops::Range;

use can_twin::board::{CoreRegister, EmulatedBoard, StateRegister};
use can_twin::image::Symbol;
use can_twin::model::FLASH_BASE;

use super::place::{Place, Target};

/// Content of an erased byte of flash.
const ERASED: u8 = 0xFF;

/// Places of one board that do not change during a flight.
#[derive(Clone, Debug)]
pub struct Places {
    variables: Vec<(String, Symbol)>,
    sections: Vec<(String, Range<u32>)>,
    /// End of the stack, which grows down.
    stack_end: u32,
    program: Range<u32>,
    /// Programmed bytes of the parameter store. Empty when nothing was saved.
    store: Range<u32>,
}

impl Places {
    /// Reads the image and the flash of a board.
    pub fn of(board: &EmulatedBoard) -> Places {
        let image = &board.config().image;
        let address = |name: &str| board.symbol(name).map_or(0, |symbol| symbol.address);
        let first = address("__store_start");
        let end = FLASH_BASE + board.config().model.part.flash_bytes();
        let content = board.read_memory(first, end.saturating_sub(first) as usize).unwrap_or_default();
        let used = content.iter().rposition(|byte| *byte != ERASED).map_or(0, |last| last as u32 + 1);
        Places {
            variables: image.variables(),
            sections: image.ram_sections(),
            stack_end: address("_stack_start"),
            program: FLASH_BASE..FLASH_BASE + image.flash().len() as u32,
            store: first..first + used,
        }
    }

    /// Returns the ranges of bytes of a place in memory. `stack`: stack pointer.
    pub fn ranges(&self, place: Place, stack: u32) -> Vec<Range<u32>> {
        match place {
            Place::Ram => {
                let sections = self.sections.iter().map(|(_, range)| range.clone());
                sections.chain(std::iter::once(stack.min(self.stack_end)..self.stack_end)).collect()
            }
            Place::Flash => vec![self.program.clone()],
            Place::Store => vec![self.store.clone()],
            Place::Core | Place::Masks | Place::Peripherals => Vec::new(),
        }
    }

    /// Returns the name of a byte in RAM: variable and offset, stack, or section.
    fn variable(&self, address: u32) -> Option<String> {
        let after = self.variables.partition_point(|(_, symbol)| symbol.address <= address);
        let here = self.variables[..after].last();
        let here = here.filter(|(_, symbol)| address - symbol.address < symbol.size);
        let section = || self.sections.iter().find(|(_, range)| range.contains(&address));
        here.map(|(name, symbol)| format!("{name} + {}", address - symbol.address))
            .or_else(|| section().map(|(name, range)| format!("{name} + {}", address - range.start)))
            .or_else(|| (address < self.stack_end).then(|| format!("stack - {}", self.stack_end - address)))
    }
}

/// Returns the name of what an upset strikes, with its bit: `TIM2.PSC bit 3`.
pub fn name(
    places: &Places,
    board: &EmulatedBoard,
    registers: &[StateRegister],
    place: Place,
    target: Target,
    bit: u32,
) -> String {
    let name = match target {
        Target::Core(register) => register.to_string(),
        Target::Address(address) => {
            let register = || registers.iter().find(|register| register.address == address);
            let named = match place {
                Place::Peripherals => register().map(|register| register.name.clone()),
                Place::Flash => board.function_at(address).map(|name| format!("{name}, {address:08X}h")),
                Place::Store => Some(format!("store + {}", address - places.store.start)),
                _ => places.variable(address),
            };
            named.unwrap_or_else(|| format!("{address:08X}h"))
        }
    };
    format!("{name} bit {bit}")
}

/// Returns the core registers of a place.
pub fn core_registers(place: Place) -> Vec<CoreRegister> {
    use CoreRegister::{Basepri, Control, Faultmask, Primask};
    let is_mask = |register: &CoreRegister| matches!(register, Primask | Basepri | Faultmask);
    let belongs = |register: &CoreRegister| match place {
        Place::Core => !is_mask(register) && *register != Control,
        Place::Masks => is_mask(register),
        _ => false,
    };
    CoreRegister::all().filter(belongs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places() -> Places {
        let variable = |name: &str, address, size| (name.to_owned(), Symbol { address, size });
        Places {
            variables: vec![variable("a::A", 0x2000_0000, 4), variable("b::B", 0x2000_0010, 8)],
            sections: vec![(".bss".into(), 0x2000_0000..0x2000_0020)],
            stack_end: 0x1001_0000,
            program: FLASH_BASE..FLASH_BASE + 16,
            store: 0x080C_0000..0x080C_0000,
        }
    }

    #[test]
    fn bytes_are_named_by_variable_section_or_stack() {
        let places = places();
        for (address, name) in [
            (0x2000_0003, Some("a::A + 3")),
            (0x2000_0017, Some("b::B + 7")),
            (0x2000_0018, Some(".bss + 24")),
            (0x1000_FFF0, Some("stack - 16")),
            (0x2000_0020, None),
        ] {
            assert_eq!(places.variable(address).as_deref(), name, "{address:08X}h");
        }
    }

    #[test]
    fn stack_in_use_begins_at_its_pointer() {
        let ranges = places().ranges(Place::Ram, 0x1000_FF00);
        assert_eq!(ranges, [0x2000_0000..0x2000_0020, 0x1000_FF00..0x1001_0000]);
        assert_eq!(places().ranges(Place::Ram, u32::MAX)[1], 0x1001_0000..0x1001_0000);
    }

    #[test]
    fn each_core_register_but_control_belongs_to_one_place() {
        let (core, masks) = (core_registers(Place::Core), core_registers(Place::Masks));
        assert_eq!((core.len(), masks.len()), (16 + 32 + 1, 3));
        assert!(masks.iter().all(|register| !core.contains(register)));
    }
}
