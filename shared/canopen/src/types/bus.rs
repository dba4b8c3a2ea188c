//! The two buses that a node may have, and one value for each. A node on one bus is on the nominal one.

/// One of the two CAN buses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum Bus {
    /// Nominal bus, in use by default.
    Nominal = 0,
    /// Redundant bus.
    Redundant = 1,
}

impl Bus {
    /// Both buses, nominal first.
    pub const ALL: [Bus; 2] = [Bus::Nominal, Bus::Redundant];

    /// Returns the alternate bus: always the other physical one, never a stored parameter.
    #[must_use]
    pub const fn other(self) -> Bus {
        match self {
            Bus::Nominal => Bus::Redundant,
            Bus::Redundant => Bus::Nominal,
        }
    }

    /// Returns the bus of a value of Bdefault (object 2000h sub 1). `None` for a value other than 0 and 1.
    pub const fn from_bdefault(value: u8) -> Option<Bus> {
        match value {
            0 => Some(Bus::Nominal),
            1 => Some(Bus::Redundant),
            _ => None,
        }
    }

    /// Returns the value of Bdefault for this bus.
    pub const fn bdefault(self) -> u8 {
        self as u8
    }
}

/// One value for each bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PerBus<T> {
    /// Value of the nominal bus.
    pub nominal: T,
    /// Value of the redundant bus.
    pub redundant: T,
}

impl<T> PerBus<T> {
    /// Calls the function for each bus.
    pub fn from_fn(mut value: impl FnMut(Bus) -> T) -> Self {
        PerBus { nominal: value(Bus::Nominal), redundant: value(Bus::Redundant) }
    }
}

impl<T> core::ops::Index<Bus> for PerBus<T> {
    type Output = T;
    fn index(&self, bus: Bus) -> &T {
        match bus {
            Bus::Nominal => &self.nominal,
            Bus::Redundant => &self.redundant,
        }
    }
}

impl<T> core::ops::IndexMut<Bus> for PerBus<T> {
    fn index_mut(&mut self, bus: Bus) -> &mut T {
        match bus {
            Bus::Nominal => &mut self.nominal,
            Bus::Redundant => &mut self.redundant,
        }
    }
}
