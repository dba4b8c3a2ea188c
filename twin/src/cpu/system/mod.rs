//! Units of the core behind system registers (B3.2 to B3.5, C1.6, C1.8): state and effect of each register.

pub mod debug;
pub mod fpb;
pub mod mpu;
pub mod nvic;
pub mod scb;
pub mod systick;
