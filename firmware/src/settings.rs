//! Calibration and zeros in flash, through any loss of power.
//!
//! Two sectors of records, each with a sequence number and a CRC-32; the valid record with the highest number counts. A
//! new one goes to the next blank place; only when a sector is full the other one is erased and written to. So the last
//! good record is never touched before a newer one is whole, whenever the power goes.

use embedded_storage::nor_flash::NorFlash;
use fixed::types::I8F24;
use model_core::actuation::PerSegment;
use model_core::protocol::checksum;
use model_core::units::{Bend, Coefficients, Pressure};

/// Bytes of a record; a multiple of every write size up to 16.
pub const RECORD: usize = 64;
/// Marks this layout.
const LAYOUT: u32 = 0x5F1E_0002;
/// The layout before: one calibration for all three segments. It is read, and never written.
const ONE_FOR_ALL: u32 = 0x5F1E_0001;

/// What survives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The model's, for each segment.
    pub coefficients: PerSegment<Coefficients>,
    /// What the pressure sensor reads at atmosphere.
    pub pressure_zero: Pressure,
    /// What the bend sensor reads at rest.
    pub bend_zero: Bend,
}

impl Settings {
    fn to_words(self, number: u32) -> impl Iterator<Item = u32> {
        let coefficients = self.coefficients.into_iter().flat_map(|own| [own.k(), own.c1(), own.c2()]);
        let zeros = [self.pressure_zero.to_bits(), self.bend_zero.to_bits()];
        let values = coefficients.map(I8F24::to_bits).chain(zeros);
        [LAYOUT, number].into_iter().chain(values.map(i32::cast_unsigned))
    }

    fn to_record(self, number: u32) -> [u8; RECORD] {
        let mut record = [0; RECORD];
        for (place, word) in record.chunks_exact_mut(4).zip(self.to_words(number)) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        if let Some((content, crc)) = record.split_last_chunk_mut() {
            *crc = checksum(content).to_le_bytes();
        }
        record
    }

    fn from_record(record: &[u8; RECORD]) -> Option<(u32, Self)> {
        let (content, crc) = record.split_last_chunk()?;
        let mut words = content.chunks_exact(4).filter_map(|word| Some(u32::from_le_bytes(word.try_into().ok()?)));
        if *crc != checksum(content).to_le_bytes() {
            return None;
        }
        let layout = words.next()?;
        let number = words.next()?;
        let mut bits = words.map(u32::cast_signed);
        let mut next = || {
            let mut coefficient = || bits.next().map(I8F24::from_bits);
            Coefficients::new(coefficient()?, coefficient()?, coefficient()?).ok()
        };
        let coefficients = match layout {
            LAYOUT => [next()?, next()?, next()?],
            ONE_FOR_ALL => [next()?; 3],
            _ => return None,
        };
        let pressure_zero = Pressure::from_bits(bits.next()?);
        Some((number, Self { coefficients, pressure_zero, bend_zero: Bend::from_bits(bits.next()?) }))
    }
}

/// Two sectors of a flash.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    sectors: [u32; 2],
    sector_bytes: u32,
    /// Place and number of the newest record.
    newest: Option<(u32, u32)>,
    /// Something is stored, and no record is whole.
    damaged: bool,
}

impl<F: NorFlash> Store<F> {
    /// On two sectors of `sector_bytes` that start at these offsets.
    pub const fn new(flash: F, sectors: [u32; 2], sector_bytes: u32) -> Self {
        Self { flash, sectors, sector_bytes, newest: None, damaged: false }
    }

    /// A sector's places from one of them on.
    fn places(&self, sector: u32, first: u32) -> impl Iterator<Item = u32> + use<F> {
        (first..sector.saturating_add(self.sector_bytes)).step_by(RECORD)
    }

    fn read(&mut self, place: u32) -> Option<[u8; RECORD]> {
        let mut record = [0; RECORD];
        self.flash.read(place, &mut record).ok()?;
        Some(record)
    }

    fn is_blank(&mut self, place: u32) -> bool {
        self.read(place).is_some_and(|record| record == [0xFF; RECORD])
    }

    /// The settings that were stored last, if any are.
    pub fn load(&mut self) -> Option<Settings> {
        let mut found: Option<(u32, u32, Settings)> = None;
        let mut used = false;
        for sector in self.sectors {
            for place in self.places(sector, sector) {
                let Some(record) = self.read(place) else { continue };
                if record == [0xFF; RECORD] {
                    // Places are used in their order, and one that was begun is not blank.
                    break;
                }
                used = true;
                if let Some((number, settings)) = Settings::from_record(&record)
                    && found.is_none_or(|(_, best, _)| number > best)
                {
                    found = Some((place, number, settings));
                }
            }
        }
        self.damaged = used && found.is_none();
        self.newest = found.map(|(place, number, _)| (place, number));
        found.map(|(_, _, settings)| settings)
    }

    /// Whether the last [`load`](Self::load) found records and none of them whole. A blank memory is not damaged.
    pub const fn is_damaged(&self) -> bool {
        self.damaged
    }

    /// Stores the settings; `before_erase` is called when a sector has to be erased, which takes the chip a second or two.
    ///
    /// # Errors
    /// When the flash refuses, or does not hold what was written; the settings from before still count then.
    pub fn save(&mut self, settings: Settings, before_erase: impl FnOnce()) -> Result<(), Failed> {
        let number = self.newest.map_or(0, |(_, number)| number.saturating_add(1));
        let place = match self.next_blank() {
            Some(place) => place,
            None => self.make_room(before_erase)?,
        };
        let record = settings.to_record(number);
        self.flash.write(place, &record).map_err(|_| Failed)?;
        if self.read(place) != Some(record) {
            return Err(Failed);
        }
        self.newest = Some((place, number));
        Ok(())
    }

    /// A blank place after the newest record, in its sector.
    fn next_blank(&mut self) -> Option<u32> {
        let sector = self.active();
        let first = self.newest.map_or(sector, |(place, _)| place.saturating_add(RECORD as u32));
        self.places(sector, first).find(|&place| self.is_blank(place))
    }

    fn active(&self) -> u32 {
        let [first, second] = self.sectors;
        match self.newest {
            Some((place, _)) if place >= second && place - second < self.sector_bytes => second,
            _ => first,
        }
    }

    fn make_room(&mut self, before_erase: impl FnOnce()) -> Result<u32, Failed> {
        let [first, second] = self.sectors;
        // Without any record the first sector holds only what was cut short, and may go itself.
        let other = if self.newest.is_some() && self.active() == first { second } else { first };
        before_erase();
        self.flash.erase(other, other.saturating_add(self.sector_bytes)).map_err(|_| Failed)?;
        Ok(other)
    }
}

/// The flash did not take the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_storage::nor_flash::{ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash};
    use model_core::calibration;

    const SECTOR: u32 = 4 * RECORD as u32;

    /// A flash of two sectors that loses power in the middle of an operation: a word, or an erasure.
    struct Memory {
        bytes: Vec<u8>,
        left: u32,
    }

    #[derive(Debug)]
    struct PowerCut;
    impl NorFlashError for PowerCut {
        fn kind(&self) -> NorFlashErrorKind {
            NorFlashErrorKind::Other
        }
    }
    impl ErrorType for Memory {
        type Error = PowerCut;
    }
    impl ReadNorFlash for Memory {
        const READ_SIZE: usize = 1;
        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerCut> {
            bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
            Ok(())
        }
        fn capacity(&self) -> usize {
            self.bytes.len()
        }
    }
    impl NorFlash for Memory {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = SECTOR as usize;
        fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerCut> {
            let bytes = &mut self.bytes[from as usize..to as usize];
            if self.left == 0 {
                bytes.iter_mut().step_by(3).for_each(|byte| *byte = 0xFF);
                return Err(PowerCut);
            }
            self.left -= 1;
            bytes.fill(0xFF);
            Ok(())
        }
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerCut> {
            for (index, word) in bytes.chunks(4).enumerate() {
                let place = &mut self.bytes[offset as usize + 4 * index..][..4];
                assert!(place.iter().all(|&byte| byte == 0xFF), "written twice");
                let mask = if self.left == 0 { 0xF0 } else { 0 };
                place.iter_mut().zip(word).for_each(|(byte, &value)| *byte &= value | mask);
                self.left = self.left.checked_sub(1).ok_or(PowerCut)?;
            }
            Ok(())
        }
    }

    fn store(memory: Memory) -> Store<Memory> {
        Store::new(memory, [0, SECTOR], SECTOR)
    }

    fn other(c1_kpa: i32) -> Coefficients {
        Coefficients::new(I8F24::ONE, I8F24::from_num(c1_kpa), I8F24::ONE).expect("admitted")
    }

    fn settings(number: i32) -> Settings {
        Settings {
            coefficients: [calibration::DEFAULT, other(10 + number % 10), other(20)],
            pressure_zero: Pressure::from_bits(number),
            bend_zero: Bend::from_bits(-number),
        }
    }

    #[test]
    fn a_cut_at_any_operation_leaves_the_old_settings_or_the_new() {
        // Nine saves go through both sectors and back.
        for cut in 0..200 {
            let mut open = store(Memory { bytes: vec![0xFF; 2 * SECTOR as usize], left: cut });
            assert_eq!(open.load(), None);
            let saved = (1..=9).take_while(|&number| open.save(settings(number), || ()).is_ok()).count() as i32;
            let mut again = store(Memory { left: u32::MAX, ..open.flash });
            let expected = [saved, saved + 1].map(|number| (number > 0).then(|| settings(number)));
            let loaded = again.load();
            assert!(expected.contains(&loaded), "cut {cut}: {saved} saved, {loaded:?} loaded");
            // And the next ones are stored as if nothing had been.
            for number in 100..120 {
                assert_eq!(again.save(settings(number), || ()), Ok(()), "cut {cut}");
            }
            let mut last = store(again.flash);
            assert_eq!(last.load(), Some(settings(119)));
        }
    }

    #[test]
    fn a_record_of_one_calibration_for_all_segments_is_read() {
        let mut record = [0; RECORD];
        let words = [ONE_FOR_ALL, 7, 1 << 24, 12 << 24, 1 << 22, 65_536, u32::MAX];
        for (place, word) in record.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        let crc = checksum(&record[..RECORD - 4]).to_le_bytes();
        record[RECORD - 4..].copy_from_slice(&crc);
        let [k, c1, c2] = [1 << 24, 12 << 24, 1 << 22].map(I8F24::from_bits);
        let coefficients = [Coefficients::new(k, c1, c2).expect("admitted"); 3];
        let settings = Settings { coefficients, pressure_zero: Pressure::from_kpa(1), bend_zero: Bend::from_bits(-1) };
        assert_eq!(Settings::from_record(&record), Some((7, settings)));
    }

    #[test]
    fn damage_is_told_from_blankness_and_from_a_good_record_beside_it() {
        let mut open = store(Memory { bytes: vec![0xFF; 2 * SECTOR as usize], left: u32::MAX });
        assert!(open.load().is_none() && !open.is_damaged());
        open.save(settings(1), || ()).expect("room");
        open.flash.bytes[20] ^= 1;
        assert!(open.load().is_none() && open.is_damaged());
        open.save(settings(2), || ()).expect("room");
        assert!(open.load() == Some(settings(2)) && !open.is_damaged());
    }

    #[test]
    fn no_damaged_record_counts() {
        let record = settings(5).to_record(9);
        assert_eq!(Settings::from_record(&record), Some((9, settings(5))));
        for bit in 0..8 * RECORD {
            let mut damaged = record;
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Settings::from_record(&damaged), None, "bit {bit}");
        }
        assert_eq!(Settings::from_record(&[0; RECORD]), None);
    }
}
