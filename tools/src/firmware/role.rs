//! The shipped images and their configuration.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::images::support::board::{BitRate, Board, Profile};
use crate::images::support::misuse::Misuse;

/// A node of the spacecraft with an image of this project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Role {
    /// The one master
    Master,
    /// Any slave: straps give its Node-ID
    Slave,
    /// Any slave of the minimal set (ECSS 9)
    Minimal,
}

impl Role {
    /// All shipped images.
    pub const ALL: [Role; 3] = [Role::Master, Role::Slave, Role::Minimal];

    /// Returns its name in the command line.
    pub fn name(self) -> &'static str {
        match self {
            Role::Master => "master",
            Role::Slave => "slave",
            Role::Minimal => "minimal",
        }
    }
}

/// Configuration of shipped images.
#[derive(Args, Clone, Copy, Debug)]
pub struct Configuration {
    /// Mission profile of shipped images; standby: two master boards [default: librecube]
    #[arg(long, value_name = "PROFILE", value_enum)]
    profile: Option<Profile>,

    /// The board has one CAN controller and two transceivers (ECSS Figure A-6); for the minimal slave
    #[arg(long)]
    one_controller: bool,

    /// Bit rate of both buses of shipped images in kbit/s [default: 1000]
    #[arg(long, value_name = "KBIT", value_enum)]
    bit_rate: Option<BitRate>,
}

impl Configuration {
    /// Returns whether an option is given.
    pub fn is_given(&self) -> bool {
        self.profile.is_some() || self.one_controller || self.bit_rate.is_some()
    }

    /// Checks that these images have this configuration. `command` is the subcommand with these options.
    ///
    /// # Errors
    /// When `--one-controller` is given without the minimal slave.
    pub fn check(&self, command: &'static str, roles: &[Role]) -> Result<(), Misuse> {
        if !self.one_controller || roles.contains(&Role::Minimal) {
            return Ok(());
        }
        let text = format!(
            "--one-controller is for the minimal slave alone: ecss-can {command} minimal --one-controller"
        );
        Err(Misuse::of(command, text))
    }

    /// Builds images for a board, with this filter of the log. Returns their ELF files. `command` is the subcommand with these
    /// options.
    ///
    /// # Errors
    /// That of [`Configuration::check`], or when an image cannot be built.
    pub fn build(
        &self,
        command: &'static str,
        roles: &[Role],
        board: &Board,
        log: &str,
    ) -> anyhow::Result<Vec<(Role, PathBuf)>> {
        self.check(command, roles)?;
        board.check_images(command)?;
        let profile = self.profile.unwrap_or(Profile::Librecube);
        let configuration = self.bit_rate.unwrap_or(BitRate::Kbit1000).configuration(profile);
        if [Role::Master, Role::Slave].iter().all(|role| roles.contains(role)) {
            // Together, so that they are compiled side by side.
            crate::images::build_logging(board.board_crate(), &configuration, log)?;
        }
        let fitting = if self.one_controller { "+one-controller" } else { "" };
        let image = |&role: &Role| {
            let fitting = if role == Role::Minimal { fitting } else { "" };
            let configuration = format!("{configuration}{fitting}");
            let path = crate::images::build_image(board.board_crate(), role.name(), &configuration, log)?;
            Ok((role, path))
        };
        roles.iter().map(image).collect()
    }
}
