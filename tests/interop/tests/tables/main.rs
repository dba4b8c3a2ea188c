//! Tables of flights in host worlds that take minutes.

mod jolts;
