//! SDO client for applications: `master.sdo(HEATER).read(Heater::POWER).await`.

use core::future::poll_fn;
use core::task::{Context, Poll};

use super::left::TRANSFER;
use super::storage::Core;
use super::{Outside, Platform};
use crate::node::ClientNode;
use crate::od::{Field, Number, Readable, Writable};
use crate::sdo::{Client, Error, Mode};
use crate::store::{LOAD, SAVE, StoreObjects};
use crate::types::{Address, NodeId};

/// Bytes handed over at once when a value streams.
const CHUNK: usize = 112;

/// Reads and writes the objects of one node, one transfer at a time.
///
/// An object is a constant of a declaration, such as `Heater::SETPOINT`, which has its type and its access right. An object
/// of a node whose declaration is not here is a [`Field::raw`], and its value is bytes.
///
/// A transfer waits for the one before it, of any task and to any node, and for the boot-up process. The boot-up process
/// lets a running transfer end, and goes before the next one. A transfer without progress for the SDO timeout of the
/// profile ends with [`Error::Timeout`]. A switch of the active bus ends it with [`Error::BusChanged`].
///
/// # Cancel safety
/// A dropped future aborts its transfer.
#[doc(alias("SDO client", "CSDO"))]
pub struct SdoClient<B: Platform, N: ClientNode> {
    core: &'static Core<B, N>,
    node: NodeId,
    mode: Mode,
}

impl<B: Platform, N: ClientNode> Clone for SdoClient<B, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: Platform, N: ClientNode> Copy for SdoClient<B, N> {}

impl<B: Platform, N: ClientNode> SdoClient<B, N> {
    /// Values of more than 28 bytes move in blocks, if the server knows them.
    pub(super) const fn new(core: &'static Core<B, N>, node: NodeId) -> Self {
        SdoClient { core, node, mode: Mode::Auto }
    }

    /// Returns the same client with this protocol for values that do not fit into one frame.
    #[must_use]
    pub const fn with_mode(self, mode: Mode) -> Self {
        SdoClient { mode, ..self }
    }

    /// Returns the Node-ID of the server.
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Reads a number.
    ///
    /// # Errors
    /// See [`Error`]. [`Error::TooLarge`] and [`Error::TooShort`] if the value of the node has another size.
    /// [`Error::UnknownValue`] if it is none of its [enumeration](macro@crate::od::Enumeration).
    ///
    /// # Cancel safety
    /// A dropped future aborts the transfer.
    pub async fn read<T: Number, W>(&self, field: Field<T, Readable, W>) -> Result<T, Error> {
        let bits = self.read_number(field.address(), T::SIZE).await?;
        T::from_bits(bits).ok_or(Error::UnknownValue(bits as u32))
    }

    /// Writes a number.
    ///
    /// # Errors
    /// See [`Error`].
    ///
    /// # Cancel safety
    /// A dropped future aborts the transfer, unless the server has the whole value already.
    pub async fn write<T: Number, R>(&self, field: Field<T, R, Writable>, value: T) -> Result<(), Error> {
        let bytes = value.bits().to_le_bytes();
        self.write_at(field.address(), bytes.get(..T::SIZE).unwrap_or(&bytes)).await
    }

    /// Stores all parameters of the node: "save" in 1010h sub-index 1.
    ///
    /// # Errors
    /// See [`Error`].
    ///
    /// # Cancel safety
    /// As [`SdoClient::write`].
    pub async fn save_all(&self) -> Result<(), Error> {
        self.write(const { StoreObjects::STORE.sub(1) }, SAVE).await
    }

    /// Restores the defaults of all parameters of the node: "load" in 1011h sub-index 1. They apply after its next reset.
    ///
    /// # Errors
    /// See [`Error`].
    ///
    /// # Cancel safety
    /// As [`SdoClient::write`].
    pub async fn restore_all(&self) -> Result<(), Error> {
        self.write(const { StoreObjects::RESTORE.sub(1) }, LOAD).await
    }

    /// Reads the bytes of a value. Returns their number.
    ///
    /// # Errors
    /// See [`Error`]. [`Error::TooLarge`] if the value does not fit into `into`.
    ///
    /// # Cancel safety
    /// A dropped future aborts the transfer. `into` may have a part of the value.
    pub async fn read_bytes<T, W>(
        &self,
        field: Field<T, Readable, W>,
        into: &mut [u8],
    ) -> Result<usize, Error> {
        self.read_at(field.address(), into).await
    }

    /// Writes the bytes of a value.
    ///
    /// # Errors
    /// See [`Error`].
    ///
    /// # Cancel safety
    /// A dropped future aborts the transfer, unless the server has the whole value already.
    pub async fn write_bytes<T, R>(&self, field: Field<T, R, Writable>, value: &[u8]) -> Result<(), Error> {
        self.write_at(field.address(), value).await
    }

    /// Reads a value of at most `most` bytes part by part. `sink` gets each part in order. Returns the number of
    /// bytes. The value is complete only if this succeeds.
    ///
    /// # Errors
    /// See [`Error`].
    ///
    /// # Cancel safety
    /// A dropped future aborts the transfer. `sink` got a part of the value.
    pub async fn upload_to<T, W>(
        &self,
        field: Field<T, Readable, W>,
        most: usize,
        mut sink: impl FnMut(&[u8]) + Outside,
    ) -> Result<usize, Error> {
        let at = field.address();
        let mut claim = self.claim(|client| client.start_upload(at, most, self.mode)).await;
        let drain = |client: &mut Client| {
            let mut chunk = [0; CHUNK];
            loop {
                match client.pull(&mut chunk) {
                    0 => return,
                    count => sink(chunk.get(..count).unwrap_or(&chunk)),
                }
            }
        };
        claim.run(drain).await
    }

    /// Writes a value of `size` bytes part by part. `source` fills each part in order.
    ///
    /// # Errors
    /// See [`Error`].
    ///
    /// # Cancel safety
    /// A dropped future aborts the transfer, unless the server has the whole value already.
    pub async fn download_from<T, R>(
        &self,
        field: Field<T, R, Writable>,
        size: usize,
        mut source: impl FnMut(&mut [u8]) + Outside,
    ) -> Result<(), Error> {
        let at = field.address();
        let mut claim = self.claim(|client| client.start_download(at, size, self.mode)).await;
        let fill = |client: &mut Client| {
            let mut chunk = [0; CHUNK];
            loop {
                let room = client.room().min(CHUNK);
                let Some(part) = chunk.get_mut(..room).filter(|part| !part.is_empty()) else { return };
                source(part);
                client.push(part);
            }
        };
        claim.run(fill).await.map(drop)
    }

    /// Reads a number of `size` bytes, into the low bits.
    async fn read_number(&self, at: Address, size: usize) -> Result<u64, Error> {
        let mut bytes = [0; 8];
        let read = self.read_at(at, bytes.get_mut(..size).unwrap_or_default()).await?;
        if read == size { Ok(u64::from_le_bytes(bytes)) } else { Err(Error::TooShort) }
    }

    async fn read_at(&self, at: Address, into: &mut [u8]) -> Result<usize, Error> {
        let most = into.len();
        let mut claim = self.claim(|client| client.start_upload(at, most, self.mode)).await;
        let mut filled = 0;
        claim.run(|client| filled += client.pull(into.get_mut(filled..).unwrap_or_default())).await
    }

    async fn write_at(&self, at: Address, value: &[u8]) -> Result<(), Error> {
        let mut claim = self.claim(|client| client.start_download(at, value.len(), self.mode)).await;
        let mut given = 0;
        claim.run(|client| given += client.push(value.get(given..).unwrap_or_default())).await.map(drop)
    }

    /// Waits for its turn and starts a transfer.
    async fn claim(&self, start: impl Fn(&mut Client)) -> Claim<B, N> {
        poll_fn(|cx| {
            let started =
                self.core.lock(|shared| shared.node.claim_sdo(self.node, cx.waker()).map(&start).is_some());
            if started { Poll::Ready(Claim { core: self.core }) } else { Poll::Pending }
        })
        .await
    }
}

/// The client belongs to one transfer as long as this lives.
struct Claim<B: Platform, N: ClientNode> {
    core: &'static Core<B, N>,
}

impl<B: Platform, N: ClientNode> Claim<B, N> {
    /// Moves bytes until the transfer is over.
    async fn run(&mut self, mut step: impl FnMut(&mut Client)) -> Result<usize, Error> {
        poll_fn(|cx| self.poll(cx, &mut step)).await
    }

    fn poll(&self, cx: &Context<'_>, step: &mut impl FnMut(&mut Client)) -> Poll<Result<usize, Error>> {
        // At the end of the call the node sends what has become possible.
        self.core.lend(|node, _| {
            let client = node.claimed_sdo(cx.waker());
            step(client);
            client.outcome().map_or(Poll::Pending, Poll::Ready)
        })
    }
}

impl<B: Platform, N: ClientNode> Drop for Claim<B, N> {
    fn drop(&mut self) {
        self.core.give_back(TRANSFER, |shared, _| shared.node.release_sdo());
    }
}
