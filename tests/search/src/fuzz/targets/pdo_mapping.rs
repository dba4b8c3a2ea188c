//! PDOs of a slave in Operational, configured by any SDOs and given any frames.

use ecss_can::node::Node;
use ecss_can::pdo::Mapping;
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, Duration, NmtState};

use super::node::{Bench, frame};
use super::pdo_reference::{Dictionary, VALUES, bytes, is_equal, is_valid, least_bytes, pack, unpack};
use crate::fuzz::{Input, Signature};

const BUS: Bus = Bus::Nominal;
/// Flags of a COB-ID: not valid, no remote frames.
const NOT_VALID: u32 = 1 << 31;
const NO_REMOTE: u32 = 1 << 30;

const COMMUNICATION: [(u8, u8); 6] = [(1, 4), (2, 1), (3, 2), (5, 2), (6, 1), (4, 1)];
const TYPES: [u8; 8] = [0, 1, 2, 240, 241, 252, 254, 255];
const FLAGS: [u32; 5] = [NO_REMOTE, NOT_VALID | NO_REMOTE, 0, NOT_VALID, 1 << 29];

struct World<'a> {
    bench: Bench,
    /// Frames of synchronous RPDOs that wait for SYNC.
    held: [Option<[u8; 8]>; 8],
    signature: &'a mut Signature,
}

/// Runs an input. An operation is a byte for its kind, and its arguments.
pub fn run(mut input: Input, signature: &mut Signature) {
    // No heartbeat is missed, because the target tests PDOs.
    let profile = Profile { consumer: Duration::ZERO, ..Profile::DEFAULT };
    let mut world = World { bench: Bench::new(&profile), held: [None; 8], signature };
    world.bench.acknowledge_boot_up();
    world.bench.receive(BUS, frame(0x701, 1, [5; 8]));
    world.command(1);
    while !input.is_empty() {
        match input.byte() % 12 {
            0..=2 => world.write_communication(&mut input),
            3 | 4 => world.write_mapping(&mut input),
            5 => world.map(&mut input),
            6 | 7 => world.receive(&mut input),
            8 => world.synchronise(),
            9 => {
                let number = usize::from(input.byte() % 9);
                world.bench.slave.send_pdo(number, world.bench.now);
                world.bench.poll();
                world.check_sent(None);
            }
            10 => {
                let until = world.bench.now + Duration::from_millis(u64::from(input.byte() % 64));
                while let Some(due) = world.bench.slave.deadline().filter(|due| *due <= until) {
                    world.bench.now = due.max(world.bench.now);
                    world.bench.poll();
                    world.check_sent(None);
                }
                world.bench.now = until;
            }
            _ => world.command(input.pick(&[1, 1, 1, 0x80, 0x82])),
        }
    }
    (0..world.held.len()).for_each(|number| world.check_active(number));
}

impl World<'_> {
    fn objects(&self) -> &Dictionary {
        self.bench.slave.objects()
    }

    fn command(&mut self, command: u8) {
        self.bench.receive(BUS, frame(0, 2, [command, 5, 0, 0, 0, 0, 0, 0]));
        if self.bench.slave.status(self.bench.now).state != NmtState::Operational {
            self.held = [None; 8];
            self.bench.acknowledge_boot_up();
        }
    }

    /// Writes one value of the communication parameters of a PDO.
    fn write_communication(&mut self, input: &mut Input) {
        let (choice, (sub, size)) = (input.byte(), input.pick(&COMMUNICATION));
        let index = if choice & 1 == 0 { 0x1400 } else { 0x1800 } + u16::from(choice / 2 % 9);
        let [a, b] = input.bytes();
        let value = match sub {
            1 => u32::from(u16::from_le_bytes([a, b]) & 0x7FF) | input.pick(&FLAGS),
            2 if b < 0xE0 => u32::from(TYPES[usize::from(a) % TYPES.len()]),
            3 => u32::from(a & 0x3F),
            _ => u32::from(a),
        };
        self.write(index, sub, size, value);
    }

    /// Writes one value of the mapping of a PDO.
    fn write_mapping(&mut self, input: &mut Input) {
        let (choice, sub) = (input.byte(), input.byte() % 10);
        let index = if choice & 1 == 0 { 0x1600 } else { 0x1A00 } + u16::from(choice / 2 % 9);
        let (size, value) = match sub {
            0 => (1, u32::from(input.byte() % 10)),
            _ => (4, entry(input)),
        };
        self.write(index, sub, size, value);
    }

    /// Writes a complete mapping: PDO invalid, nothing mapped, the objects, their number, PDO valid.
    fn map(&mut self, input: &mut Input) {
        let (choice, kind, count) = (input.byte(), input.pick(&TYPES), input.byte() % 6);
        let number = u16::from(choice / 2 % 8);
        let base = if choice & 1 == 0 { 0x1400 } else { 0x1800 } + number;
        let id = u32::from(0x180 + (u16::from(input.byte()) << 3 & 0x3F8) + number) | NO_REMOTE;
        let pdos = &self.objects().pdos;
        let present = match base {
            0x1400..=0x15FF => pdos.rpdos[usize::from(number)].cob_id,
            _ => pdos.tpdos[usize::from(number)].cob_id,
        };
        self.write(base, 1, 4, NOT_VALID | present);
        self.write(base, 1, 4, NOT_VALID | id);
        self.write(base, 2, 1, u32::from(kind));
        self.write(base + 0x200, 0, 1, 0);
        for sub in 1..=count {
            self.write(base + 0x200, sub, 4, entry(input));
        }
        self.write(base + 0x200, 0, 1, u32::from(count));
        self.write(base, 1, 4, id);
    }

    fn write(&mut self, index: u16, sub: u8, size: u8, value: u32) {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let of = |objects: &Dictionary| {
            let now = &objects.pdos;
            (now.rpdos, now.rpdo_mappings, now.tpdos, now.tpdo_mappings)
        };
        let before = of(self.objects());
        self.bench.receive(BUS, frame(0x605, 8, [0x23 | (4 - size) << 2, low, high, sub, a, b, c, d]));
        let answer = self.bench.sent.iter().find(|(_, frame)| frame.id().raw() == 0x585);
        let (_, answer) = answer.expect("an answer");
        let [command, _, _, _, code @ ..] = answer.padded();
        self.signature.note(
            u32::from(index >> 8) << 24
                | u32::from(sub) << 16
                | u32::from(code[0]) << 8
                | u32::from(code[2]) ^ u32::from(code[3]),
        );
        let number = usize::from(index & 0x1FF);
        if command == 0x60 {
            if let (0x1400..=0x15FF, Some(held)) = (index, self.held.get_mut(number)) {
                *held = None;
            }
            self.check_active(number);
        } else {
            assert_eq!(command, 0x80);
            assert!(before == of(self.objects()), "refused, but written");
        }
    }

    /// Checks that a valid PDO may be valid.
    fn check_active(&self, number: usize) {
        let now = &self.objects().pdos;
        let is_valid_id = |cob_id: u32| cob_id & NOT_VALID == 0;
        if let Some(pdo) = now.rpdos.get(number).filter(|pdo| is_valid_id(pdo.cob_id)) {
            let mapping = now.rpdo_mappings[number].objects();
            check_id(pdo.cob_id, pdo.transmission);
            assert!(is_valid(mapping, true), "{mapping:08X?}");
        }
        if let Some(pdo) = now.tpdos.get(number).filter(|pdo| is_valid_id(pdo.cob_id)) {
            let mapping = now.tpdo_mappings[number].objects();
            check_id(pdo.cob_id, pdo.transmission);
            assert!(pdo.cob_id & NO_REMOTE != 0, "remote frames");
            assert!(pdo.cob_id & 0x7FF != 0x085, "as emergencies are");
            assert!(is_valid(mapping, false), "{mapping:08X?}");
            let twins = now
                .tpdos
                .iter()
                .filter(|other| is_valid_id(other.cob_id) && other.cob_id & 0x7FF == pdo.cob_id & 0x7FF);
            assert_eq!(twins.count(), 1, "sent by two");
        }
    }

    /// Receives a frame of an RPDO, or of any identifier.
    fn receive(&mut self, input: &mut Input) {
        let choice = input.byte();
        let id = match self.objects().pdos.rpdos.get(usize::from(choice % 16)) {
            Some(pdo) => (pdo.cob_id & 0x7FF) as u16,
            None => input.word() & 0x7FF,
        };
        // These identifiers are not of PDOs.
        if matches!(id, 0 | 0x080 | 0x605 | 0x700..=0x77F) {
            return;
        }
        let dlc = input.byte();
        let dlc = if dlc < 0xC0 { 8 } else { dlc % 9 };
        let received = frame(id, dlc, input.bytes());
        let mut expected = self.objects().clone();
        if self.bench.slave.status(self.bench.now).state == NmtState::Operational {
            let pdos = expected.pdos.rpdos;
            for (number, pdo) in pdos.iter().enumerate() {
                let mapping = expected.pdos.rpdo_mappings[number];
                if pdo.cob_id & (NOT_VALID | 0x7FF) != u32::from(id) || dlc < least_bytes(mapping.objects()) {
                    continue;
                }
                self.signature
                    .note(0x1000 | u32::from(pdo.transmission) << 4 | mapping.objects().len() as u32);
                // A time is that of the SYNC before it (ECSS 7.2.3c).
                let brings_time = mapping.objects().iter().any(|object| object >> 16 == 0x2010);
                if pdo.transmission <= 240 && !brings_time {
                    self.held[number] = Some(received.padded());
                } else {
                    unpack(mapping.objects(), received.padded(), &mut expected);
                }
            }
        }
        self.bench.receive(BUS, received);
        self.compare(&expected);
    }

    /// Receives SYNC: held frames take effect.
    fn synchronise(&mut self) {
        let mut expected = self.objects().clone();
        let before = expected.clone();
        if self.bench.slave.status(self.bench.now).state == NmtState::Operational {
            for (number, held) in self.held.iter_mut().enumerate() {
                if let Some(data) = held.take() {
                    let mapping = expected.pdos.rpdo_mappings[number];
                    unpack(mapping.objects(), data, &mut expected);
                }
            }
        }
        self.bench.receive(BUS, frame(0x080, 0, [0; 8]));
        self.compare(&expected);
        self.check_sent(Some(before));
    }

    fn compare(&self, expected: &Dictionary) {
        let now = self.objects();
        assert!(is_equal(now, expected), "{:X?}\n{:X?}", now.application, expected.application);
    }

    /// Checks that a sent frame has the present values, or those before a SYNC.
    fn check_sent(&mut self, before: Option<Dictionary>) {
        if self.bench.sent.is_empty() {
            return;
        }
        let mut objects = before.unwrap_or_else(|| self.objects().clone());
        for (_, sent) in &self.bench.sent {
            let id = u32::from(sent.id().raw());
            let mut pdos = objects.pdos.tpdos.iter();
            let found = pdos.position(|pdo| pdo.cob_id & (NOT_VALID | 0x7FF) == id);
            let Some(number) = found else { continue };
            let mapping = objects.pdos.tpdo_mappings[number];
            let mapping = mapping.objects();
            self.signature.note(0x2000 | number as u32);
            assert_eq!(sent.dlc(), bytes(mapping));
            // Time, its quality and health of the buses are sampled at the SYNC. Changes of errors are reported after
            // it.
            if mapping.iter().all(|entry| !matches!(entry >> 16, 0x2011 | 0x2015 | 0x2020 | 0x2021 | 0x1001))
            {
                assert_eq!(sent.padded(), pack(mapping, &mut objects), "{mapping:08X?}");
            }
        }
    }
}

/// CiA 301 table 40: identifiers that no PDO may have; and its transmission types.
fn check_id(cob_id: u32, transmission: u8) {
    let restricted = matches!(cob_id & 0x7FF, 0..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..);
    assert!(cob_id & 0x7FF != 0x080, "as SYNC is");
    assert!(!restricted && cob_id & 0x3FFF_F800 == 0, "COB-ID {cob_id:08X}");
    assert!(matches!(transmission, 0..=240 | 254 | 255), "type {transmission}");
}

/// A mapping entry: mostly of something that can be mapped.
fn entry(input: &mut Input) -> u32 {
    let (choice, odd) = (input.byte(), input.byte());
    let value = VALUES[usize::from(choice) % VALUES.len()];
    let entry = u32::from(value.at.index) << 16 | u32::from(value.at.sub) << 8 | u32::from(value.bits);
    match odd {
        0xF8.. => u32::from(odd & 7) << 16 | u32::from(choice & 0x3F),
        0xF0.. => entry ^ 1 << (choice % 32),
        0xEF => 0,
        _ => entry,
    }
}
