//! Declarations of data sheets in another form.

use ecss_can::od::eds;

eds! {
    pub enum Valve = "valve.eds";
}

eds! {
    pub struct Valve = valve;
}

eds! {
    pub struct Valve = "valve.eds"
}

fn main() {}
