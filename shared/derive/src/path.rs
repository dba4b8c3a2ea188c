//! Paths to the crates of the expanded code, as the expanding package names them in its manifest.
//!
//! The dictionary is of `async-canopen`. A package that depends on `ecss-can` alone reaches it there.

use proc_macro_crate::{FoundCrate, crate_name};
use proc_macro2::{Ident, Span, TokenStream};
use quote::quote_spanned;

const CANOPEN: &str = "async-canopen";
const ECSS: &str = "ecss-can";

/// Returns the path to the modules of CANopen. A package of CANopen may depend on `ecss-can` for its tests alone, so that name
/// comes second.
pub fn canopen() -> TokenStream {
    canopen_at(Span::call_site())
}

/// Returns the same path, for errors that are reported at `span`. Without any of the two crates it names the one that is
/// missing.
pub fn canopen_at(span: Span) -> TokenStream {
    let found = path(CANOPEN, span).or_else(|| path(ECSS, span));
    found.unwrap_or_else(|| quote_spanned!(span=> ::async_canopen))
}

/// Returns the path to the modules of a node. `None` if the package does not depend on `ecss-can`.
pub fn ecss_at(span: Span) -> Option<TokenStream> {
    path(ECSS, span)
}

fn path(package: &str, span: Span) -> Option<TokenStream> {
    let name = match crate_name(package).ok()? {
        // Both crates have their own name within themselves.
        FoundCrate::Itself => package.replace('-', "_"),
        FoundCrate::Name(name) => name,
    };
    let name = Ident::new(&name, span);
    Some(quote_spanned!(span=> ::#name))
}
