//! Service data objects: server and client (CiA 301 7.2.4, ECSS 6.1).
