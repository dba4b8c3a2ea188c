//! Time objects of a node: times that PDOs and clients write, and times that they read (ECSS 7.1, 7.2).

use async_canopen::node::extend::NodeEvent;
use easy_ext::ext;

use super::Services;
use super::mapped::{MappedTime, is_local_time};
use crate::boot::machine::CommonPdo;
use crate::emcy::ErrorCode;
use crate::link::Stamp;
use crate::node::index::{CLOCK_QUALITY, HEARTBEAT_SENT, SCET_GET, SCET_SET, UTC_GET, UTC_SET};
use crate::node::{NodeObjects, SpacecraftDevice, SpacecraftEvent, Turn};
use crate::od::CobIdEntry;
use crate::od::checked::find;
use crate::pdo::machine::rules::is_synchronous;
use crate::pdo::{Mapping, PdoSlots};
use crate::time::{LocalScet, LocalUtc, PairOutcome, Places, TimeCorrection, TimeService, mean_of_truncated};
use crate::types::{AbortCode, Address, CobId, FineInstant, FineScet, Frame, Instant, Scet, Utc};

/// Binary places of a second that hold a microsecond, and a millisecond.
const BITS_OF_MICROS: u32 = 20;
const BITS_OF_MS: u32 = 10;
/// The mean of what is lost without microseconds, 499.5 of them in units of 2^-32 s.
const MEAN_OF_MICROS: i64 = 2_145_336;

/// Sources of EMCY 9000h: the clock was stepped because the spacecraft times contradict it; SYNCs of this master
/// are stamped in the interrupt; the rate of the clock is at the limit of the crystals.
const CLOCK_STEPPED: u8 = 0x10;
const SYNC_UNCAPTURED: u8 = 0x11;
const CLOCK_SATURATED: u8 = 0x12;
/// Source of EMCY 8150h: two nodes send the spacecraft time.
const TWO_PRODUCERS: u8 = 0x81;

/// Sub-index of 2012h with the submilliseconds.
const SUBMILLISECONDS: Address = Address::new(UTC_SET, 3);

/// Lowest bits of a time of a producer without capture wires, of 24 places or microseconds: zero.
const LOWEST: u16 = 7;
/// Half of what they are worth, units of 2^-32 s: 0.24 and 4 us.
const HALF_OF_SCET: i64 = 1 << 10;
const HALF_OF_UTC: i64 = 17_180;

/// Bits of a command specifier that distinguish an upload from all other requests.
const UPLOADS: u8 = 0xE3;
/// Initiate upload.
const UPLOAD: u8 = 0x40;
/// Initiate block upload.
const BLOCK_UPLOAD: u8 = 0xA0;

/// Checks a `value` that a client writes: submilliseconds of a device that has them (7.1.3g) are below 1000.
///
/// # Errors
/// [`AbortCode::ValueTooHigh`].
pub fn check_submilliseconds<D: SpacecraftDevice>(at: Address, value: u32) -> Result<(), AbortCode> {
    let has_limit = const { D::UTC.is_some() && D::SUBMILLISECONDS };
    let is_too_high = has_limit && at == SUBMILLISECONDS && value >= 1_000;
    if is_too_high { Err(AbortCode::ValueTooHigh) } else { Ok(()) }
}

#[ext(TimeServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Returns clock and time service.
    pub fn time(&self) -> &TimeService {
        self.state().time()
    }

    /// Lends clock and time service.
    pub fn time_mut(&mut self) -> &mut TimeService {
        self.state_mut().time_mut()
    }

    /// Lends clock and time service. Returns the correction of the stamps, too.
    pub fn time_and_correction(&mut self) -> (&mut TimeService, &TimeCorrection) {
        let (objects, state) = self.objects_and_state();
        (state.time_mut(), objects.extension.correction())
    }

    /// Returns the local spacecraft time.
    pub fn scet(&self, now: Instant) -> Scet {
        self.time().clock().at(now.into()).scet()
    }

    /// Returns the spacecraft time at the last SYNC.
    pub fn scet_at_sync(&mut self) -> Option<Scet> {
        let at = self.last_sync()?;
        Some(self.time().clock().at(at).scet())
    }

    /// Returns when the last SYNC ended at its producer.
    pub fn last_sync(&mut self) -> Option<FineInstant> {
        let (time, correction) = self.time_and_correction();
        time.last_sync(correction)
    }

    /// Shows the time `scet` in 2011h and 2013h; `is_short`: rounded, with the lowest three bits zero.
    pub fn show_time(&mut self, scet: FineScet, is_short: bool) {
        let NodeObjects { application, extension: objects, .. } = self.objects_mut();
        let (bits, scet, utc, used) = if is_short {
            (Places::SHORT, scet.plus(HALF_OF_SCET), scet.plus(HALF_OF_UTC), !LOWEST)
        } else {
            (D::FINE_BITS, scet, scet, !0)
        };
        // 7.1.2g: what a device lacks is zero, not rounded.
        objects.time.scet_get = scet.scet().truncated(bits.min(D::FINE_BITS)).into();
        if let (Some(relation), Some(objects)) = (D::UTC, application.utc()) {
            let utc = relation.utc(utc);
            objects.utc_get = if D::SUBMILLISECONDS { utc } else { utc.whole_ms() }.into();
            objects.utc_get.submilliseconds &= used;
        }
    }

    /// Samples the local time for transmit PDOs.
    pub fn refresh_time(&mut self, at: FineInstant) {
        let (scet, is_short) = (self.time().clock().at(at), self.time().is_coarse());
        self.show_time(scet, is_short);
    }

    /// Samples the local time for transmit PDOs that are sent without SYNC. It is the time of the last SYNC if
    /// the spacecraft time is distributed with SYNC (ECSS 7.2.3k), otherwise the present time (7.2.2).
    pub fn refresh_time_of_events(&mut self, now: Instant) {
        let of_sync = if self.state().is_time_by_sync() { self.last_sync() } else { None };
        self.refresh_time(of_sync.unwrap_or_else(|| now.into()));
    }

    /// Samples the time objects that an SDO request may read. There is one sample for all parts of a record. The
    /// server ignores requests of other lengths, and so does the sample.
    pub fn refresh_time_for(&mut self, request: &Frame, now: Instant) {
        let Some(&[command, low, high, sub, ..]) = request.full() else { return };
        let at = Address::new(u16::from_le_bytes([low, high]), sub);
        self.choose_client(request.id());
        let parts = if at.index == SCET_GET { LocalScet::PARTS } else { LocalUtc::PARTS };
        if is_local_time(at.index)
            && matches!(command & UPLOADS, UPLOAD | BLOCK_UPLOAD)
            && let Some(sample) = self.time_mut().read(at, parts, now)
        {
            self.show_time(sample, false);
        }
        if at.index == CLOCK_QUALITY {
            self.refresh_quality(now);
        }
        if at.index == HEARTBEAT_SENT {
            self.time_mut().range();
        }
    }

    /// Updates object 2015h.
    pub fn refresh_quality(&mut self, now: Instant) {
        let (objects, state) = self.objects_and_state();
        objects.extension.show_quality(state.time(), now);
    }

    /// Gives the time service the samples of the client that sends requests with this COB-ID: parts that a client reads one by
    /// one belong to one sample, whatever the other client reads between them.
    pub fn choose_client(&mut self, request: CobId) {
        let nth = self.server_of(request);
        self.state_mut().choose_client(nth);
    }

    /// Takes the end of a heartbeat of this node (2016h). This instant and the one at which another node received
    /// the heartbeat give the delay of the cable between them.
    pub fn note_heartbeat(&mut self, stamp: &Stamp) {
        if let Some(sent) = self.time_mut().on_heartbeat(stamp.fine()) {
            self.objects_mut().extension.show_heartbeat(sent);
        }
    }

    /// Takes a spacecraft time that another master sent, as this one would send it. Returns whether the frame was
    /// one.
    pub fn overhear_time<V: NodeEvent<Extension = SpacecraftEvent>>(
        &mut self,
        frame: &Frame,
        stamp: &Stamp,
        turn: &mut Turn<'_, V>,
    ) -> bool {
        let Some((number, pdo)) = self.numbered_time_pdo().filter(|(_, pdo)| pdo.id == frame.id()) else {
            return false;
        };
        let objects = self.objects_mut();
        let (mut bits, mut carried) = (frame.bits(), MappedTime::None);
        for nth in 0.. {
            let tpdos = objects.pdos.tpdos().1;
            let Some(mapped) = tpdos.get(number).and_then(|mapping| mapping.objects().get(nth).copied())
            else {
                break;
            };
            let [length, sub, ..] = mapped.to_le_bytes();
            let (index, kind) = match (mapped >> 16) as u16 {
                SCET_GET => (SCET_SET, MappedTime::Scet),
                UTC_GET => (UTC_SET, MappedTime::Utc),
                // The time is what comes first.
                _ => break,
            };
            if let Ok(mut found) = find(objects, Address::new(index, sub)) {
                let value = bits & u64::MAX.checked_shr(64 - u32::from(length)).unwrap_or(0);
                let _ = found.take(&value.to_le_bytes());
                carried = kind;
            }
            bits = bits.checked_shr(length.into()).unwrap_or(0);
        }
        carried != MappedTime::None
            && self.follow_time(carried, is_synchronous(pdo.transmission), stamp, turn)
    }

    /// Lets the clock follow a received time. Returns whether the value is a time.
    pub fn follow_time<V: NodeEvent<Extension = SpacecraftEvent>>(
        &mut self,
        kind: MappedTime,
        by_sync: bool,
        stamp: &Stamp,
        turn: &mut Turn<'_, V>,
    ) -> bool {
        self.time_mut().forget_written();
        let Some((scet, places)) = self.received_time(kind) else { return false };
        let (time, correction) = self.time_and_correction();
        let was_set = time.clock().is_synchronised();
        time.on_places(places);
        let taken = if by_sync {
            time.at_last_sync(scet, correction, turn.now)
        } else {
            time.at_reception(scet, stamp.fine(), turn.now)
        };
        match taken {
            PairOutcome::Unused => {}
            PairOutcome::Steered => turn.out.event(V::extension(SpacecraftEvent::Time(scet.scet()))),
            PairOutcome::Stepped(step) => {
                turn.out.event(V::extension(SpacecraftEvent::Time(scet.scet())));
                turn.out.signal(V::extension(SpacecraftEvent::Step(step)));
                if was_set {
                    self.report_past(ErrorCode::EXTERNAL, [CLOCK_STEPPED, 0, 0, 0, 0]);
                }
            }
        }
        self.report_clock();
        true
    }

    /// Raises and clears the emergencies of the clock.
    pub fn report_clock(&mut self) {
        let time = self.time();
        let (are_two, is_saturated) = (time.has_two_producers(), time.clock().is_saturated());
        self.set_error(ErrorCode::CAN_ID_COLLISION, TWO_PRODUCERS, are_two);
        self.set_error(ErrorCode::EXTERNAL, CLOCK_SATURATED, is_saturated);
    }

    /// Notes that this node sent a SYNC. Returns whether it was found just now that its SYNCs are not captured.
    pub fn on_sync_produced(&mut self) -> bool {
        let is_uncaptured = self.time().is_uncaptured();
        self.set_error(ErrorCode::EXTERNAL, SYNC_UNCAPTURED, is_uncaptured)
    }

    /// Returns the time that a PDO has written into 2010h or 2012h, and its places. The mean of the places that it lacks is
    /// added. `None`: the value is no time.
    pub fn received_time(&mut self, kind: MappedTime) -> Option<(FineScet, Places)> {
        let NodeObjects { application, extension: objects, .. } = self.objects_mut();
        if kind == MappedTime::Utc {
            let bits = if D::SUBMILLISECONDS { BITS_OF_MICROS } else { BITS_OF_MS };
            // 7.1.3g: bits that a device lacks do not say how the producer stamps.
            let is_short = D::SUBMILLISECONDS && application.utc()?.utc_set.submilliseconds & LOWEST == 0;
            return received_utc(application).map(|scet| (scet, Places { bits, is_short }));
        }
        // 7.1.2h: what a device lacks it does not look at.
        let scet = Scet::from(objects.time.scet_set).truncated(D::FINE_BITS);
        let bits = D::FINE_BITS.min(u32::from(objects.correction().fine_bits));
        let is_short = bits > Places::SHORT && scet.fine() as u16 & LOWEST == 0;
        Some((FineScet::from(scet).plus(mean_of_truncated(bits)), Places { bits, is_short }))
    }

    /// Sets the clock by command.
    pub fn set_time<V: NodeEvent<Extension = SpacecraftEvent>>(
        &mut self,
        scet: FineScet,
        turn: &mut Turn<'_, V>,
    ) {
        let step = self.time_mut().set(scet, turn.now.into());
        turn.out.signal(V::extension(SpacecraftEvent::Step(step)));
    }

    /// Takes a write to 2010h or 2012h by a client. The clock is set when the last sub-index of the record is
    /// written.
    pub fn on_time_written<V: NodeEvent<Extension = SpacecraftEvent>>(
        &mut self,
        at: Address,
        turn: &mut Turn<'_, V>,
    ) {
        let parts = match at.index {
            SCET_SET => LocalScet::PARTS,
            UTC_SET => LocalUtc::PARTS,
            _ => return,
        };
        // Noted whatever the other parts are: a PDO may have left a time there that is none.
        if !self.time_mut().on_part_written(at, parts, turn.now) {
            return;
        }
        let NodeObjects { application, extension: objects, .. } = self.objects_mut();
        let scet = if at.index == SCET_SET {
            Some(FineScet::from(Scet::from(objects.time.scet_set).truncated(D::FINE_BITS)))
        } else {
            received_utc(application)
        };
        if let Some(scet) = scet {
            self.set_time(scet, turn);
        }
    }

    /// Returns the first valid transmit PDO that carries the local time.
    pub fn time_pdo(&self) -> Option<CommonPdo> {
        self.numbered_time_pdo().map(|(_, pdo)| pdo)
    }

    pub fn numbered_time_pdo(&self) -> Option<(usize, CommonPdo)> {
        self.time_pdos().next()
    }

    /// Returns number and parameters of each valid transmit PDO that carries the local time.
    pub fn time_pdos(&self) -> impl Iterator<Item = (usize, CommonPdo)> {
        let (tpdos, _) = self.objects().pdos.tpdos();
        let carriers = tpdos.iter().enumerate().filter(|(number, _)| self.state().carries_time(*number));
        carriers.filter_map(|(number, pdo)| {
            let id = CobIdEntry::from_raw(pdo.cob_id).cob_id()?;
            Some((number, CommonPdo { id, transmission: pdo.transmission }))
        })
    }
}

/// Returns the time in 2012h.
fn received_utc<D: SpacecraftDevice>(application: &mut D) -> Option<FineScet> {
    let (relation, objects) = D::UTC.zip(application.utc())?;
    let mut received = objects.utc_set;
    if !D::SUBMILLISECONDS {
        // 7.1.3g: any value is allowed there.
        received.submilliseconds = 0;
    }
    let scet = FineScet::from(relation.scet(Utc::try_from(received).ok()?));
    Some(if D::SUBMILLISECONDS { scet } else { scet.plus(MEAN_OF_MICROS) })
}
