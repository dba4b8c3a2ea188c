//! Memory of a board that keeps its content without power or over a reset: flash for parameters, two words of RAM.

use std::sync::{Arc, Mutex};

use ecss_can::store::{ParameterStore, RetainedMemory, StoreError};

/// RAM that keeps its content over a reset, undefined after power-on.
#[derive(Clone)]
pub(crate) struct Ram(Arc<Mutex<[u32; 2]>>);

impl Ram {
    pub fn of_power_on() -> Ram {
        Ram(Arc::new(Mutex::new([0x5A5A_0F0F, 0x0FF0_1234])))
    }
}

impl RetainedMemory for Ram {
    fn read(&self) -> [u32; 2] {
        *self.0.lock().expect("one thread")
    }

    fn write(&mut self, words: [u32; 2]) {
        *self.0.lock().expect("one thread") = words;
    }
}

/// Flash for parameters: keeps sets of any length. Clones share the flash; each has its own unfinished set.
#[derive(Clone, Default)]
pub(crate) struct Flash {
    kept: Arc<Mutex<Kept>>,
    begun: Vec<u8>,
    announced: usize,
}

#[derive(Default)]
struct Kept {
    set: Vec<u8>,
    note: Option<u16>,
}

impl ParameterStore for Flash {
    fn stored_len(&self) -> usize {
        self.kept.lock().expect("one thread").set.len()
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<(), StoreError> {
        let kept = self.kept.lock().expect("one thread");
        into.copy_from_slice(kept.set.get(offset..offset + into.len()).ok_or(StoreError::Size)?);
        Ok(())
    }

    fn begin(&mut self, len: usize) -> Result<(), StoreError> {
        self.begun.clear();
        self.announced = len;
        Ok(())
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        self.begun.extend(bytes);
        if self.begun.len() > self.announced { Err(StoreError::Size) } else { Ok(()) }
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        if self.begun.len() < self.announced {
            return Err(StoreError::Size);
        }
        *self.kept.lock().expect("one thread") = Kept { set: std::mem::take(&mut self.begun), note: None };
        Ok(())
    }

    fn note(&self) -> Option<u16> {
        self.kept.lock().expect("one thread").note
    }

    fn write_note(&mut self, note: u16) -> Result<(), StoreError> {
        if note > 0x0FFF {
            return Err(StoreError::Size);
        }
        self.kept.lock().expect("one thread").note = Some(note);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_is_kept_when_it_is_complete_and_not_before() {
        let mut flash = Flash::default();
        flash.begin(4).expect("room");
        flash.append(&[1, 2]).expect("announced");
        assert_eq!((flash.commit(), flash.stored_len()), (Err(StoreError::Size), 0));
        flash.append(&[3, 4]).expect("announced");
        assert_eq!(flash.append(&[5]), Err(StoreError::Size));
        flash.begin(2).expect("room");
        flash.append(&[6, 7]).expect("announced");
        flash.commit().expect("complete");
        let mut set = [0; 2];
        flash.clone().read(0, &mut set).expect("within the set");
        assert_eq!(set, [6, 7]);
        assert_eq!(flash.read(1, &mut set), Err(StoreError::Size));
    }

    #[test]
    fn a_note_lasts_until_the_next_set() {
        let mut flash = Flash::default();
        assert_eq!(flash.write_note(0x1000), Err(StoreError::Size));
        flash.write_note(7).expect("twelve bits");
        assert_eq!(flash.note(), Some(7));
        flash.begin(0).expect("room");
        flash.commit().expect("complete");
        assert_eq!(flash.note(), None);
    }
}
