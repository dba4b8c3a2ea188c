//! Flights whose images take long to build: drivers of others, further bit rates.

mod drivers_of_others;
mod rates;
