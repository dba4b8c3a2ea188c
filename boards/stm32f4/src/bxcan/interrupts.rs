//! Interrupt handlers of a controller: each handler reads all flags, clears those that it read, and wakes the port.
//!
//! All handlers have the same priority and do not interrupt each other.

use core::marker::PhantomData;

use embassy_stm32::interrupt::typelevel::{Binding, Handler};

use super::controller::Controller;

/// Interrupts of a controller, bound to the handlers of this driver.
pub trait ControllerInterrupts<T: Controller>:
    Binding<T::TXInterrupt, TransmitHandler<T>>
    + Binding<T::RX0Interrupt, ReceiveHandler<T>>
    + Binding<T::SCEInterrupt, StatusHandler<T>>
{
}

impl<T: Controller, I> ControllerInterrupts<T> for I where
    I: Binding<T::TXInterrupt, TransmitHandler<T>>
        + Binding<T::RX0Interrupt, ReceiveHandler<T>>
        + Binding<T::SCEInterrupt, StatusHandler<T>>
{
}

/// Handler of the transmit interrupt.
pub struct TransmitHandler<T>(PhantomData<T>);

/// Handler of the interrupt of receive FIFO 0.
pub struct ReceiveHandler<T>(PhantomData<T>);

/// Handler of the status change and error interrupt.
pub struct StatusHandler<T>(PhantomData<T>);

impl<T: Controller> Handler<T::TXInterrupt> for TransmitHandler<T> {
    unsafe fn on_interrupt() {
        T::events().on_transmit_interrupt(T::REGISTERS);
    }
}

impl<T: Controller> Handler<T::RX0Interrupt> for ReceiveHandler<T> {
    unsafe fn on_interrupt() {
        T::events().on_receive_interrupt(T::REGISTERS);
    }
}

impl<T: Controller> Handler<T::SCEInterrupt> for StatusHandler<T> {
    unsafe fn on_interrupt() {
        T::events().on_status_interrupt(T::REGISTERS);
    }
}
