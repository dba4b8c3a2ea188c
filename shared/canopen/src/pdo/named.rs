//! PDO with a name: a constant that its sender, its receivers and their applications share.

use core::fmt;
use core::marker::PhantomData;

use super::carried::{Carried, tell_object};
use super::planned::{Rpdo, Tpdo};
use super::values::{Append, PdoValues};
use super::{CobIdOf, Direction, MAPPED};
use crate::od::{Access, DataType, Field, Number, Reason};
use crate::types::{Address, CobId, Frame, NodeId};

/// PDO of a device `D`: its COB-ID and its values, of the types `T`.
///
/// It is declared once, beside the objects of the device. The device lists it in its [`PdoSet`](super::PdoSet), as
/// [received](Pdo::receive) or [transmitted](Pdo::transmit). Another node binds it to the Node-ID of a device by
/// [`Pdo::of`].
///
/// ```
/// use async_canopen::prelude::*;
///
/// /// A heater.
/// #[derive(Objects)]
/// #[objects(device)]
/// struct Heater {
///     /// Setpoint
///     #[object(0x6000, rww, pdo)]
///     setpoint: i16,
///     /// Power
///     #[object(0x6001, ro, pdo)]
///     power: u8,
/// }
///
/// /// Command: 200h + node.
/// const COMMAND: Pdo<Heater, (i16,)> = Pdo::new(CobIdOf::node(0x200)).map(Heater::SETPOINT);
/// /// Change of the power: 280h + node.
/// const CHANGE: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x280)).map(Heater::POWER);
///
/// impl Device for Heater {
///     type Pdos = PdoObjects<4, 4>;
///     type Consumers = HeartbeatConsumers<1>;
///     const PDOS: PdoSet = PdoSet::new(&[COMMAND.receive(1)], &[CHANGE.transmit(2)]);
/// }
///
/// /// Another node has no object for the power of heater 5: its application reads it from the event.
/// const OTHER: PdoSet = PdoSet::new(&[CHANGE.of(NodeId::of::<5>()).receive(1)], &[]);
/// ```
pub struct Pdo<D, T = ()> {
    cob_id: CobIdOf,
    carried: Carried,
    /// Access rights of the values. `None`: the value has no object.
    access: [Option<Access>; MAPPED],
    of: PhantomData<fn(D, T)>,
}

impl<D, T> Clone for Pdo<D, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D, T> Copy for Pdo<D, T> {}

impl<D, T> fmt::Debug for Pdo<D, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pdo").field("cob_id", &self.cob_id).field("carried", &self.carried).finish()
    }
}

/// PDO of the device at a node: a [`Pdo`] that is bound to a Node-ID.
pub struct NodePdo<T> {
    cob_id: CobId,
    bytes: u8,
    of: PhantomData<fn(T)>,
}

impl<T> Clone for NodePdo<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for NodePdo<T> {}

impl<T> fmt::Debug for NodePdo<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NodePdo").field("cob_id", &self.cob_id).field("bytes", &self.bytes).finish()
    }
}

impl<D> Pdo<D> {
    /// Makes a PDO that carries nothing yet.
    pub const fn new(cob_id: CobIdOf) -> Self {
        Pdo { cob_id, carried: Carried::NOTHING, access: [None; MAPPED], of: PhantomData }
    }
}

impl<D, T> Pdo<D, T> {
    /// Carries this value behind those before.
    ///
    /// # Panics
    /// For a value that is not for PDOs, after 8 values, and beyond 64 bits. In a constant all panics of this module are compile errors.
    #[track_caller]
    pub const fn map<V: Number, R, W>(self, field: Field<V, R, W>) -> Pdo<D, T::And<V>>
    where
        T: Append,
    {
        let (at, entry) = (field.address(), field.entry());
        if !entry.is_mappable() {
            tell_object(Reason::new(""), at).text(" is not for PDOs: add `pdo` to its declaration").refuse();
        }
        self.with(at, entry.data_type, Some(entry.access))
    }

    /// Carries a value for which the receiving device has no object (CiA 301 7.4.8.2, dummy mapping).
    ///
    /// # Panics
    /// For a type without a dummy entry, after 8 values, and beyond 64 bits.
    #[track_caller]
    pub const fn skip<V: Number>(self) -> Pdo<D, T::And<V>>
    where
        T: Append,
    {
        if DataType::of_dummy(V::TYPE.index()).is_none() {
            panic!("only BOOLEAN and integers of 8, 16 and 32 bits can be skipped");
        }
        self.with(Address::new(V::TYPE.index(), 0), V::TYPE, None)
    }

    /// Returns the same PDO with a struct for its values, which derives [`PdoValues`](macro@super::PdoValues). Its fields have the
    /// types of the values, in their order; two of one type are the same for the compiler.
    pub const fn into_struct<S: PdoValues<Tuple = T>>(self) -> Pdo<D, S> {
        Pdo { cob_id: self.cob_id, carried: self.carried, access: self.access, of: PhantomData }
    }

    /// Makes it receive PDO 1 to 512 of the device.
    ///
    /// # Panics
    /// For another number, and if no receive PDO may carry one of the values.
    #[track_caller]
    pub const fn receive(self, number: u16) -> Rpdo {
        self.assert_allowed(Direction::Receive);
        Rpdo::new(number, self.cob_id, self.carried)
    }

    /// Makes it transmit PDO 1 to 512 of the device.
    ///
    /// # Panics
    /// For another number, for the COB-ID of the node's own EMCY, and if no transmit PDO may carry one of the values.
    #[track_caller]
    pub const fn transmit(self, number: u16) -> Tpdo {
        self.assert_allowed(Direction::Transmit);
        Tpdo::new(number, self.cob_id, self.carried)
    }

    #[track_caller]
    const fn with<U>(self, at: Address, of: DataType, access: Option<Access>) -> Pdo<D, U> {
        let (carried, mut all) = (self.carried.with(self.cob_id, at, of), self.access);
        all[self.carried.count as usize] = access;
        Pdo { cob_id: self.cob_id, carried, access: all, of: PhantomData }
    }

    #[track_caller]
    const fn assert_allowed(&self, direction: Direction) {
        let mut nth = 0;
        while let Some((at, _)) = self.carried.nth(nth) {
            let object = tell_object(Reason::new(""), at);
            match (direction, self.access[nth]) {
                (Direction::Receive, None) => {}
                (Direction::Transmit, None) => object.text(" is a gap, for receive PDOs alone").refuse(),
                (_, Some(access)) if direction.allows(access) => {}
                (_, Some(access)) => {
                    let allowed = match direction {
                        Direction::Receive => "`: a receive PDO carries `wo`, `rw` and `rww`",
                        Direction::Transmit => "`: a transmit PDO carries `ro`, `rw`, `rwr` and `constant`",
                    };
                    object.text(" is `").text(access.word()).text(allowed).refuse();
                }
            }
            nth += 1;
        }
    }

    /// Returns the PDO of the device at `node`.
    pub const fn of(self, node: NodeId) -> NodePdo<T> {
        NodePdo { cob_id: self.cob_id.of(node), bytes: self.carried.bytes(), of: PhantomData }
    }

    /// Returns the COB-ID.
    pub const fn cob_id(self) -> CobIdOf {
        self.cob_id
    }
}

impl<T> NodePdo<T> {
    /// Makes it receive PDO 1 to 512 of another device, which has no objects for its values: its application reads them
    /// from the event.
    ///
    /// # Panics
    /// For another number.
    #[track_caller]
    pub const fn receive(self, number: u16) -> Rpdo {
        let cob_id = CobIdOf::fixed(self.cob_id.raw());
        let mut carried = Carried::NOTHING;
        while carried.bytes() < self.bytes {
            let of = match self.bytes - carried.bytes() {
                4.. => DataType::Unsigned32,
                2.. => DataType::Unsigned16,
                _ => DataType::Unsigned8,
            };
            carried = carried.with(cob_id, Address::new(of.index(), 0), of);
        }
        Rpdo::new(number, cob_id, carried)
    }

    /// Returns the COB-ID.
    pub const fn cob_id(self) -> CobId {
        self.cob_id
    }

    /// Returns the number of bytes of its payload.
    pub const fn bytes(self) -> u8 {
        self.bytes
    }

    /// Returns the frame that carries these values.
    pub fn frame(self, values: T) -> Frame
    where
        T: PdoValues,
    {
        Frame::from_dlc(self.cob_id, self.bytes, values.pack().to_le_bytes())
    }
}

/// PDO that a node may receive: a [`Pdo`] of its device, or a [`NodePdo`] of another one.
pub trait Received: Copy {
    /// Values that it carries.
    type Values: PdoValues;

    /// Returns the COB-ID as the set of the receiver has it.
    fn declared_as(self) -> CobIdOf;
}

impl<D, T: PdoValues> Received for Pdo<D, T> {
    type Values = T;

    fn declared_as(self) -> CobIdOf {
        self.cob_id
    }
}

impl<T: PdoValues> Received for NodePdo<T> {
    type Values = T;

    fn declared_as(self) -> CobIdOf {
        CobIdOf::of_node(self.cob_id)
    }
}
