//! Boot-up of one slave: checks its identity, compares its configuration, and writes the values that differ.

use crate::boot::{BootCause, BootError, BootFailure, BootProgress, Difference, Expected, Setting};
use crate::od::CobIdEntry;
use crate::pdo::rules;
use crate::sdo::Error;
use crate::types::{AbortCode, Address, CobId, NodeId};

/// Attempts with a slave that does not answer: a frame may have been lost.
const ATTEMPTS: u8 = 3;

/// Indices of the objects that the process reads from every slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identified {
    /// Index of the device type (1000h).
    pub device_type: u16,
    /// Index of the identity object (1018h).
    pub identity: u16,
    /// Index of "verify configuration" (1020h).
    pub configuration: u16,
    /// Index of the communication parameters of RPDO 1 (1400h).
    pub rpdo: u16,
    /// Index of the COB-ID of the emergency message (1014h).
    pub emergency: u16,
    /// Index of the communication parameters of TPDO 1 (1800h).
    pub tpdo: u16,
}

/// PDO of the master that slaves may consume, such as that of the time. The transmission types of its producer and of the
/// slaves must match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommonPdo {
    /// COB-ID of the PDO.
    pub id: CobId,
    /// Transmission type that the producer uses.
    pub transmission: u8,
}

/// RPDOs of a slave that are searched for the common PDO.
const RPDOS: u8 = 8;
/// TPDOs of a slave whose COB-IDs are compared with those of other nodes.
const TPDOS: u8 = 8;

/// Next SDO transfer of the boot-up process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootRequest<'a> {
    /// Reads a value of a slave.
    Read {
        /// Node-ID of the slave.
        node: NodeId,
        /// Object of the slave.
        at: Address,
        /// Largest number of bytes that the value may have.
        most: usize,
    },
    /// Writes a value to a slave.
    Write {
        /// Node-ID of the slave.
        node: NodeId,
        /// Object of the slave.
        at: Address,
        /// Value, little-endian.
        value: &'a [u8],
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    DeviceType,
    Identity(u8),
    Stamp(u8),
    Compare(usize),
    Write(usize),
    /// COB-ID of an RPDO.
    TimeId(u8),
    /// Transmission type of the one that is the common PDO.
    CommonType(u8),
    /// COB-ID that the slave sends: 0 of its emergencies, then of its TPDOs.
    Sent(u8),
    WriteStamp(u8),
}

/// The step after a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Do another transfer.
    Transfer,
    /// Start the slave.
    Start,
    /// The slave is not the expected one, or did not answer.
    Fail(BootFailure),
}

#[derive(Clone, Debug)]
pub(super) struct Process {
    pub node: NodeId,
    objects: Identified,
    expected: Expected,
    settings: &'static [Setting],
    common: Option<CommonPdo>,
    step: Step,
    attempts: u8,
    /// An SDO abort ended the process once, and it began again.
    is_retried: bool,
    /// The slave keeps 1020h.
    is_stamped: bool,
    /// 1020h has the expected values: nothing else was compared, and it need not be written.
    is_verified: bool,
    /// COB-ID that the slave sends, just read, and its object.
    sent: Option<(Address, CobId)>,
    /// The first four bytes of the value that is read, or the value that is written to 1020h.
    number: [u8; 4],
    /// Bytes read.
    read: usize,
    /// The bytes read equal those of the setting.
    is_equal: bool,
    /// The transfer of this step was handed out.
    pub is_asked: bool,
    /// The first value of its configuration that was not the expected one.
    deviation: Option<Difference>,
}

impl Process {
    pub fn new(
        node: NodeId,
        objects: Identified,
        expected: Expected,
        settings: &'static [Setting],
        common: Option<CommonPdo>,
    ) -> Process {
        Process {
            node,
            objects,
            is_stamped: expected.stamp != [0; 2],
            is_verified: false,
            sent: None,
            expected,
            settings,
            common,
            step: Step::DeviceType,
            attempts: 1,
            is_retried: false,
            number: [0; 4],
            read: 0,
            is_equal: true,
            is_asked: false,
            deviation: None,
        }
    }

    pub fn progress(&self) -> BootProgress {
        match self.step {
            Step::DeviceType | Step::Identity(_) => BootProgress::Checking,
            Step::TimeId(_) | Step::CommonType(_) | Step::Sent(_) if self.is_configured() => {
                BootProgress::Configuring
            }
            Step::Stamp(_) | Step::Compare(_) | Step::TimeId(_) | Step::CommonType(_) | Step::Sent(_) => {
                BootProgress::Comparing
            }
            Step::Write(_) | Step::WriteStamp(_) => BootProgress::Configuring,
        }
    }

    /// Returns the SDO transfer of this step.
    pub fn request(&mut self) -> BootRequest<'_> {
        (self.is_asked, self.read, self.is_equal) = (true, 0, true);
        let (node, at) = (self.node, self.object());
        match self.step {
            Step::DeviceType
            | Step::Identity(_)
            | Step::Stamp(_)
            | Step::TimeId(_)
            | Step::CommonType(_)
            | Step::Sent(_) => BootRequest::Read { node, at, most: 4 },
            Step::Compare(number) => BootRequest::Read { node, at, most: self.setting(number).1.len() },
            Step::Write(number) => BootRequest::Write { node, at, value: self.setting(number).1 },
            Step::WriteStamp(sub) => {
                self.number = self.stamp(sub).to_le_bytes();
                BootRequest::Write { node, at, value: &self.number }
            }
        }
    }

    fn setting(&self, number: usize) -> (Address, &'static [u8]) {
        self.settings
            .get(number)
            .map_or((Address::new(self.objects.device_type, 0), &[]), |setting| (setting.at, setting.value))
    }

    fn stamp(&self, sub: u8) -> u32 {
        let [date, time] = self.expected.stamp;
        if sub == 1 { date } else { time }
    }

    /// Takes bytes that the running transfer read.
    pub fn on_data(&mut self, part: &[u8]) {
        if let Step::Compare(number) = self.step {
            let (_, value) = self.setting(number);
            self.is_equal &= value.get(self.read..).is_some_and(|rest| rest.starts_with(part));
        }
        if self.read == 0 {
            self.number = first_four(part);
        }
        self.read = self.read.saturating_add(part.len());
    }

    /// Takes the outcome of the transfer.
    #[inline(never)] // row `size.pyboard-v11.master.flash`
    pub fn on_done(&mut self, outcome: Result<(), Error>) -> Next {
        self.is_asked = false;
        match outcome {
            Err(Error::Timeout) if self.attempts < ATTEMPTS => {
                self.attempts = self.attempts.saturating_add(1);
                self.begin_again()
            }
            outcome => match self.judge(outcome) {
                Ok(Some(step)) => {
                    self.step = step;
                    Next::Transfer
                }
                Ok(None) => Next::Start,
                // The slave may have been busy, or in another state, for a moment.
                Err(_) if is_abort(outcome) && !self.is_retried => {
                    self.is_retried = true;
                    self.begin_again()
                }
                Err(failure) => Next::Fail(failure),
            },
        }
    }

    fn begin_again(&mut self) -> Next {
        self.step = Step::DeviceType;
        self.is_verified = false;
        Next::Transfer
    }

    /// Returns the next step, if there is one.
    fn judge(&mut self, outcome: Result<(), Error>) -> Result<Option<Step>, BootFailure> {
        let found = u32::from_le_bytes(self.number);
        let at = self.object();
        let failed = |error: BootError| {
            move |cause: Error| BootFailure { error, cause: BootCause::Transfer { at, code: cause.code() } }
        };
        let other = |error: BootError, expected: u32| {
            Err(BootFailure { error, cause: BootCause::Difference(Difference { at, expected, found }) })
        };
        match self.step {
            Step::DeviceType => {
                outcome.map_err(failed(BootError::NoResponse))?;
                let expected = self.expected.device_type;
                if expected != 0 && found != expected {
                    return other(BootError::DeviceType, expected);
                }
                Ok(self.after_identity(0))
            }
            Step::Identity(sub) => {
                let error = BootError::of_identity(sub);
                outcome.map_err(failed(error))?;
                let expected = self.identity(sub);
                if found != expected { other(error, expected) } else { Ok(self.after_identity(sub)) }
            }
            Step::Stamp(sub) => {
                match outcome {
                    Ok(()) if found != self.stamp(sub) => self.deviates(self.stamp(sub)),
                    Ok(()) if sub == 1 => return Ok(Some(Step::Stamp(2))),
                    Ok(()) => {
                        self.is_verified = true;
                        return Ok(Some(Step::Sent(0)));
                    }
                    Err(Error::Abort(AbortCode::NoObject | AbortCode::NoSubIndex)) => self.is_stamped = false,
                    Err(cause) => return Err(failed(BootError::Configuration)(cause)),
                }
                Ok(self.compare_from(0))
            }
            Step::Compare(nth) => {
                let (_, value) = self.setting(nth);
                match outcome {
                    Ok(()) if self.is_equal && self.read == value.len() => {
                        return Ok(self.compare_from(nth.saturating_add(1)));
                    }
                    Ok(()) => self.deviates(u32::from_le_bytes(first_four(value))),
                    // An object that cannot be read is written without comparison.
                    Err(Error::TooLarge | Error::Abort(_)) => {}
                    Err(cause) => return Err(failed(BootError::Configuration)(cause)),
                }
                Ok(Some(Step::Write(nth)))
            }
            Step::Write(nth) => {
                outcome.map_err(failed(BootError::Configuration))?;
                Ok(self.compare_from(nth.saturating_add(1)))
            }
            Step::TimeId(nth) => match outcome {
                Ok(()) if self.is_common(found) => Ok(Some(Step::CommonType(nth))),
                Ok(()) => Ok(self.common_from(nth.saturating_add(1))),
                // No more RPDOs.
                Err(Error::Abort(_)) => Ok(self.common_from(RPDOS)),
                Err(cause) => Err(failed(BootError::Configuration)(cause)),
            },
            Step::CommonType(_) => {
                outcome.map_err(failed(BootError::Configuration))?;
                let expected = self.common.map_or(0, |common| common.transmission);
                if rules::is_synchronous(found as u8) != rules::is_synchronous(expected) {
                    return other(BootError::Configuration, expected.into());
                }
                Ok(self.common_from(RPDOS))
            }
            Step::Sent(nth) => match outcome {
                Ok(()) => {
                    self.sent = CobIdEntry::from_raw(found).cob_id().map(|id| (at, id));
                    Ok(self.sent_from(nth.saturating_add(1)))
                }
                // The slave has no such object.
                Err(Error::Abort(_)) => Ok(self.sent_from(nth.saturating_add(1))),
                Err(cause) => Err(failed(BootError::Configuration)(cause)),
            },
            Step::WriteStamp(sub) => {
                outcome.map_err(failed(BootError::Configuration))?;
                Ok((sub == 1).then_some(Step::WriteStamp(2)))
            }
        }
    }

    /// The object of this step.
    fn object(&self) -> Address {
        match self.step {
            Step::DeviceType => Address::new(self.objects.device_type, 0),
            Step::Identity(sub) => Address::new(self.objects.identity, sub),
            Step::Stamp(sub) | Step::WriteStamp(sub) => Address::new(self.objects.configuration, sub),
            Step::Compare(number) | Step::Write(number) => self.setting(number).0,
            Step::TimeId(nth) => Address::new(self.objects.rpdo.wrapping_add(nth.into()), 1),
            Step::CommonType(nth) => Address::new(self.objects.rpdo.wrapping_add(nth.into()), 2),
            Step::Sent(0) => Address::new(self.objects.emergency, 0),
            Step::Sent(nth) => Address::new(self.objects.tpdo.wrapping_add(nth.into()).wrapping_sub(1), 1),
        }
    }

    /// Notes that the value just read is not that of the configuration.
    fn deviates(&mut self, expected: u32) {
        let found = u32::from_le_bytes(self.number);
        self.deviation.get_or_insert(Difference { at: self.object(), expected, found });
    }

    /// Returns the first difference from the configuration, once.
    pub fn take_deviation(&mut self) -> Option<Difference> {
        self.deviation.take()
    }

    /// Returns a COB-ID that the slave sends, with its object, once.
    pub fn take_sent(&mut self) -> Option<(Address, CobId)> {
        self.sent.take()
    }

    fn identity(&self, sub: u8) -> u32 {
        let nth = usize::from(sub).wrapping_sub(1);
        self.expected.identity.get(nth).copied().unwrap_or(0)
    }

    fn after_identity(&self, sub: u8) -> Option<Step> {
        let next = (sub.saturating_add(1)..=4).find(|sub| self.identity(*sub) != 0);
        match next {
            Some(sub) => Some(Step::Identity(sub)),
            None if self.is_stamped => Some(Step::Stamp(1)),
            None => self.compare_from(0),
        }
    }

    fn compare_from(&self, number: usize) -> Option<Step> {
        let rest = self.settings.iter().enumerate().skip(number);
        let mine = rest.into_iter().find(|(_, setting)| setting.node == self.node);
        match mine {
            Some((number, _)) => Some(Step::Compare(number)),
            None => self.common_from(0),
        }
    }

    /// Returns whether the slave has settings that were compared and written.
    fn is_configured(&self) -> bool {
        !self.is_verified
            && (self.is_stamped || self.settings.iter().any(|setting| setting.node == self.node))
    }

    /// Returns the step that searches the RPDOs from this one on.
    fn common_from(&self, nth: u8) -> Option<Step> {
        if self.common.is_some() && nth < RPDOS {
            return Some(Step::TimeId(nth));
        }
        Some(Step::Sent(0))
    }

    /// Returns the step that reads COB-IDs that the slave sends from this one on, or what follows.
    fn sent_from(&self, nth: u8) -> Option<Step> {
        if nth <= TPDOS {
            return Some(Step::Sent(nth));
        }
        (self.is_stamped && !self.is_verified).then_some(Step::WriteStamp(1))
    }

    /// Returns whether a COB-ID of an RPDO is valid and that of the common PDO.
    fn is_common(&self, cob_id: u32) -> bool {
        CobIdEntry::from_raw(cob_id)
            .cob_id()
            .is_some_and(|id| self.common.is_some_and(|common| common.id == id))
    }
}

const fn is_abort(outcome: Result<(), Error>) -> bool {
    matches!(outcome, Err(Error::Abort(_) | Error::UnknownAbort(_)))
}

/// The first four bytes of a value, zero behind its end.
fn first_four(value: &[u8]) -> [u8; 4] {
    core::array::from_fn(|nth| value.get(nth).copied().unwrap_or(0))
}
