use crate::pages::{Found, PAGES_MAX, Pages};
use crate::{Record, Value};
use core::ops::Range;
use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::KeyPointerCache;
use sequential_storage::map::{MapConfig, MapStorage};

/// Largest key of a record. The keys above it are the store's own.
pub const RECORD_KEY_MAX: u32 = u32::MAX - 2;

/// Longest set, in bytes: five per record and its value.
pub const SET_LEN_MAX: usize = 512;

const KEY_SET: u32 = u32::MAX;
const KEY_EPOCH: u32 = u32::MAX - 1;

/// Keys whose place in flash is remembered. With more keys a store searches the pages, and works.
const KEYS_CACHED: usize = 160;

const EPOCH_LEN: usize = 4;
const KEY_LEN: usize = 4;
const PAYLOAD_LEN_MAX: usize = EPOCH_LEN + SET_LEN_MAX;
const ITEM_LEN_MAX: usize = (KEY_LEN + PAYLOAD_LEN_MAX).next_multiple_of(8);

/// Records of parameters in the sectors of a flash.
///
/// `F` erases in sectors of `F::ERASE_SIZE` bytes and programs words of 1, 2, 4 or 8; a word may be
/// programmed again as long as bits only go from 1 to 0. Dropping a future of this type loses no
/// stored record: what it had begun is finished or undone by the next call.
///
/// Erases come from `store` and `store_all` only, one sector at a time, when a sector is full:
/// with sectors of 16 KB and forty keys of four bytes once per 775 records. Four sectors of
/// 10 000 cycles thus last for 31 million records (NM17x STORE-01 asks for one million).
pub struct Store<F: NorFlash> {
    map: MapStorage<u32, Pages<F>, KeyPointerCache<PAGES_MAX, u32, KEYS_CACHED>>,
    /// Records of an earlier epoch were forgotten by [`Store::erase_all`].
    epoch: u32,
    item: [u8; ITEM_LEN_MAX],
    payload: [u8; PAYLOAD_LEN_MAX],
}

/// The state a memory was found in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opened {
    /// Factory-new memory: no records.
    Blank,
    /// Nothing unusual.
    Intact,
    /// A loss of supply had interrupted the recycling of a sector. No record is lost.
    Resumed,
    /// The memory could not be read and was erased: all records are lost.
    Lost,
}

/// Whether a call changed the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// The records are new or differ from those stored before.
    Written,
    /// The same was stored already: the memory is not worn.
    Unchanged,
}

/// Why a record could not be stored or read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The flash driver refused a range, reported a failure or lost its supply.
    Flash,
    /// There are more records than the sectors can hold.
    Full,
    /// A set longer than [`SET_LEN_MAX`] or a key above [`RECORD_KEY_MAX`].
    NotARecord,
    /// What is read is not what was written. [`Store::erase_all`] makes the memory usable again.
    Corrupted,
}

impl<F: NorFlash> Store<F> {
    /// The store in the 2..=4 whole sectors of `range`, in `F`'s addresses. Finishes what a loss of
    /// supply had interrupted, so it may erase.
    ///
    /// # Errors
    /// [`Error::Flash`]: `range` is no such range, or the driver failed.
    pub async fn open(flash: F, range: Range<u32>) -> Result<(Self, Opened), Error> {
        let mut pages = Pages::new(flash, &range).ok_or(Error::Flash)?;
        let found = pages.open().await.map_err(|_| Error::Flash)?;
        let config = MapConfig::try_new(pages.range()).ok_or(Error::Flash)?;
        let mut store = Self {
            map: MapStorage::new(pages, config, KeyPointerCache::new()),
            epoch: 0,
            item: [0; ITEM_LEN_MAX],
            payload: [0; PAYLOAD_LEN_MAX],
        };
        let opened = match store.read_epoch().await {
            Ok(epoch) => {
                store.epoch = epoch;
                match found {
                    Found::Blank => Opened::Blank,
                    Found::Stamped => Opened::Intact,
                    Found::EraseUnfinished => Opened::Resumed,
                }
            }
            Err(Error::Corrupted | Error::NotARecord | Error::Full) => {
                store.map.erase_all().await.map_err(failure)?;
                Opened::Lost
            }
            Err(Error::Flash) => return Err(Error::Flash),
        };
        Ok((store, opened))
    }

    /// Calls `each` for every record, single ones first, then those of the set. A key stored several
    /// times may come several times: the last one counts.
    ///
    /// # Errors
    /// [`Error::Flash`], [`Error::Corrupted`]; the records handed over until then are good.
    pub async fn load_all(&mut self, mut each: impl FnMut(Record)) -> Result<(), Error> {
        let mut items = self.map.fetch_all_items(&mut self.item).await.map_err(failure)?;
        while let Some((key, payload)) =
            items.next::<&[u8]>(&mut self.item).await.map_err(failure)?
        {
            let value = body_of(payload, self.epoch).and_then(Value::from_bytes);
            if let (0..=RECORD_KEY_MAX, Some(value)) = (key, value) {
                each(Record { key, value });
            }
        }
        let set = self.map.fetch_item::<&[u8]>(&mut self.item, &KEY_SET).await.map_err(failure)?;
        let mut rest = set.and_then(|payload| body_of(payload, self.epoch)).unwrap_or_default();
        while !rest.is_empty() {
            let (record, tail) = split_record(rest).ok_or(Error::Corrupted)?;
            each(record);
            rest = tail;
        }
        Ok(())
    }

    /// Stores one record at once, unless the same value is stored already. A key lives either here
    /// or in the set of [`Store::store_all`], not in both.
    ///
    /// # Errors
    /// [`Error::NotARecord`] for a key above [`RECORD_KEY_MAX`], [`Error::Full`], [`Error::Flash`],
    /// [`Error::Corrupted`]; the value before is then still stored, except that after
    /// [`Error::Flash`] it may be either.
    pub async fn store(&mut self, record: &Record) -> Result<Stored, Error> {
        if record.key > RECORD_KEY_MAX {
            return Err(Error::NotARecord);
        }
        let bytes = record.value.as_bytes();
        self.payload
            .get_mut(EPOCH_LEN..EPOCH_LEN + bytes.len())
            .ok_or(Error::NotARecord)?
            .copy_from_slice(bytes);
        self.store_payload(record.key, bytes.len()).await
    }

    /// Replaces the set by `records`: after a loss of supply the whole old set is found or the
    /// whole new one. Not written if the same set, in the same order, is stored already.
    ///
    /// # Errors
    /// [`Error::NotARecord`] for a key above [`RECORD_KEY_MAX`] or a set longer than
    /// [`SET_LEN_MAX`]; the others as for [`Store::store`].
    pub async fn store_all(
        &mut self,
        records: impl IntoIterator<Item = Record>,
    ) -> Result<Stored, Error> {
        let mut len = 0;
        for Record { key, value } in records {
            let bytes = value.as_bytes();
            if key > RECORD_KEY_MAX {
                return Err(Error::NotARecord);
            }
            let start = EPOCH_LEN + len;
            let (head, tail) = self
                .payload
                .get_mut(start..start + SET_HEAD_LEN + bytes.len())
                .ok_or(Error::NotARecord)?
                .split_at_mut(SET_HEAD_LEN);
            let [a, b, c, d] = key.to_le_bytes();
            head.copy_from_slice(&[a, b, c, d, value.len()]);
            tail.copy_from_slice(bytes);
            len += SET_HEAD_LEN + bytes.len();
        }
        self.store_payload(KEY_SET, len).await
    }

    /// Forgets all records, single ones and the set, in one step: after a loss of supply all are
    /// still there or none is. A memory that takes no more records is erased physically; this step
    /// alone may leave some of them.
    ///
    /// # Errors
    /// [`Error::Flash`]; the records may then be there or not.
    pub async fn erase_all(&mut self) -> Result<(), Error> {
        let next = self.epoch.wrapping_add(1);
        self.epoch = match self.store_epoch(next).await {
            Ok(()) => next,
            Err(Error::Flash) => return Err(Error::Flash),
            Err(Error::Full | Error::NotARecord | Error::Corrupted) => {
                self.map.erase_all().await.map_err(failure)?;
                0
            }
        };
        Ok(())
    }

    async fn read_epoch(&mut self) -> Result<u32, Error> {
        let stored = self.map.fetch_item::<u32>(&mut self.item, &KEY_EPOCH).await;
        Ok(stored.map_err(failure)?.unwrap_or_default())
    }

    async fn store_epoch(&mut self, epoch: u32) -> Result<(), Error> {
        self.map.store_item(&mut self.item, &KEY_EPOCH, &epoch).await.map_err(failure)?;
        if self.read_epoch().await? == epoch { Ok(()) } else { Err(Error::Corrupted) }
    }

    /// Stores the `len` bytes that follow the epoch in `self.payload`.
    async fn store_payload(&mut self, key: u32, len: usize) -> Result<Stored, Error> {
        let payload = self.payload.get_mut(..EPOCH_LEN + len).ok_or(Error::NotARecord)?;
        let (epoch, _) = payload.split_at_mut(EPOCH_LEN);
        epoch.copy_from_slice(&self.epoch.to_le_bytes());
        let payload: &[u8] = payload;
        let before = self.map.fetch_item::<&[u8]>(&mut self.item, &key).await.map_err(failure)?;
        if before == Some(payload) {
            return Ok(Stored::Unchanged);
        }
        self.map.store_item(&mut self.item, &key, &payload).await.map_err(failure)?;
        let after = self.map.fetch_item::<&[u8]>(&mut self.item, &key).await.map_err(failure)?;
        if after == Some(payload) { Ok(Stored::Written) } else { Err(Error::Corrupted) }
    }
}

/// Key and length of a record within the set.
const SET_HEAD_LEN: usize = KEY_LEN + 1;

const _: () = assert!(SET_LEN_MAX >= 56 * (SET_HEAD_LEN + 4), "fifty-six numbers fit");

/// The payload without its epoch; `None` if the epoch is over.
fn body_of(payload: &[u8], epoch: u32) -> Option<&[u8]> {
    payload.strip_prefix(&epoch.to_le_bytes())
}

fn split_record(set: &[u8]) -> Option<(Record, &[u8])> {
    let (&[a, b, c, d, len], rest) = set.split_first_chunk::<SET_HEAD_LEN>()?;
    let (bytes, rest) = rest.split_at_checked(usize::from(len))?;
    let record = Record { key: u32::from_le_bytes([a, b, c, d]), value: Value::from_bytes(bytes)? };
    Some((record, rest))
}

fn failure<E>(error: sequential_storage::Error<E>) -> Error {
    use sequential_storage::Error as Map;
    match error {
        Map::Storage { .. } => Error::Flash,
        Map::FullStorage => Error::Full,
        Map::ItemTooBig => Error::NotARecord,
        Map::Corrupted { .. }
        | Map::LogicBug { .. }
        | Map::BufferTooBig
        | Map::BufferTooSmall(_)
        | Map::SerializationError(_)
        | _ => Error::Corrupted,
    }
}
