//! Builder of a master.

use super::Master;
use crate::emcy::PostMortem;
use crate::node::{Hardware, SpacecraftDevice};
use crate::profile::Profile;
use crate::redundancy::{MasterBoards, OneBoard, Strap, TwoBoards};
use crate::store::ParameterStore;

/// Builder of a [`Master`]. A board gives all that its master uses at once, as `hardware`:
///
/// ```
/// use ecss_can::node::{Hardware, SpacecraftDevice};
/// use ecss_can::prelude::*;
///
/// fn master<D: SpacecraftDevice + Default>(hardware: Hardware) -> Master<D> {
///     Master::builder(&Profile::DEFAULT, D::default()).hardware(hardware).build()
/// }
/// ```
#[derive(Debug)]
#[must_use = "`build` makes the master"]
pub struct MasterBuilder<'p, D: SpacecraftDevice, B: MasterBoards = OneBoard> {
    boards: B,
    profile: &'p Profile,
    device: D,
    hardware: Hardware,
}

impl<D: SpacecraftDevice> Master<D> {
    /// Begins a master that is the only one, without a parameter store.
    pub fn builder(profile: &Profile, device: D) -> MasterBuilder<'_, D> {
        MasterBuilder { boards: OneBoard, profile, device, hardware: Hardware::default() }
    }
}

impl<'p, D: SpacecraftDevice> MasterBuilder<'p, D> {
    /// Makes it one of two masters. `strap` is the number of the board (ECSS 8.1a, Figure 4-2). The board listens
    /// first, and then becomes active or the standby. With a profile that has no numbers for two boards
    /// ([`Profile::standby`]) it is as the only master.
    pub fn one_of_two(self, strap: Strap) -> MasterBuilder<'p, D, TwoBoards> {
        let MasterBuilder { profile, device, hardware, .. } = self;
        MasterBuilder { boards: TwoBoards::new(profile.standby, strap), profile, device, hardware }
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> MasterBuilder<'_, D, B> {
    /// Takes everything that the board has for its master: parameter store and record of the last reset. It replaces
    /// what was set before.
    pub fn hardware(self, hardware: Hardware) -> Self {
        MasterBuilder { hardware, ..self }
    }

    /// Takes a parameter store: objects 1010h and 1011h work, and the stored parameters apply from power-on.
    pub fn store(mut self, store: &'static mut (dyn ParameterStore + Send)) -> Self {
        self.hardware.store = Some(store);
        self
    }

    /// Takes the record of the last reset for object 2032h. An emergency follows the boot-up message: 6100h, 3200h
    /// for a brown-out, 5000h for the oscillator; none without a cause.
    pub fn post_mortem(mut self, record: PostMortem) -> Self {
        self.hardware.post_mortem = record;
        self
    }

    /// Makes the master, before power-on.
    #[inline(always)] // row `size.pyboard-v11.master.stack`: made in its place
    pub fn build(self) -> Master<D, B> {
        let MasterBuilder { boards, profile, device, hardware } = self;
        Master::new(boards, profile, device, hardware)
    }
}
