//! Expands `eds!`: constants of a node from the data sheet of its maker.

mod names;
mod pdos;
#[cfg(test)]
mod tests;
mod values;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use async_canopen_eds::DataSheet;
use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Error, Ident, LitStr, Token, Visibility};

use crate::errors::Errors;
use crate::path;
use pdos::Pdo;

/// What stands in the macro.
pub struct Nodes(Vec<Node>);

/// `pub struct Valve = "valve.eds";`
struct Node {
    attributes: Vec<Attribute>,
    visibility: Visibility,
    ident: Ident,
    file: LitStr,
}

impl Parse for Nodes {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let mut nodes = Vec::new();
        loop {
            nodes.push(input.parse()?);
            if input.is_empty() {
                return Ok(Nodes(nodes));
            }
        }
    }
}

impl Parse for Node {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        let visibility = input.parse()?;
        input.parse::<Token![struct]>()?;
        let ident = input.parse()?;
        input.parse::<Token![=]>()?;
        let file = input.parse()?;
        input.parse::<Token![;]>()?;
        Ok(Node { attributes, visibility, ident, file })
    }
}

/// `folder` is that of the manifest of the package.
pub fn expand(nodes: &Nodes, folder: &Path) -> TokenStream {
    nodes.0.iter().map(|node| of_node(node, folder)).collect()
}

fn of_node(node: &Node, folder: &Path) -> TokenStream {
    let Node { attributes, visibility, ident, file } = node;
    let path = folder.join(file.value());
    let mut errors = Errors::default();
    let (mut track, mut constants, mut notes) = (TokenStream::new(), Vec::new(), Vec::new());
    if let Some(bytes) = errors.take(bytes(file, &path)) {
        let path = path.to_string_lossy();
        // A change of the file compiles the package again.
        track = quote!(
            const _: &[::core::primitive::u8] = ::core::include_bytes!(#path);
        );
        let mut wrong = |error: &dyn std::fmt::Display| {
            errors.add(Error::new(file.span(), format!("{}: {error}", file.value())));
        };
        match DataSheet::read(&bytes) {
            Err(error) => wrong(&error),
            Ok(sheet) => match of_sheet(&sheet, &mut wrong) {
                made if made.0.is_empty() => {
                    wrong(&"no objects; there is a section for each, such as [6000]")
                }
                made => (constants, notes) = made,
            },
        }
    }
    let errors = errors.finish().map_err(Errors::texts).err();
    quote! {
        #(#attributes)*
        #(#[doc = #notes])*
        #[allow(dead_code)]
        #visibility struct #ident;

        #[allow(dead_code)]
        impl #ident {
            #(#constants)*
        }

        #track
        #errors
    }
}

fn bytes(file: &LitStr, path: &PathBuf) -> syn::Result<Vec<u8>> {
    fs::read(path).map_err(|error| {
        let path = path.display();
        let message = if error.kind() == ErrorKind::NotFound {
            format!(
                "no file {path}: the path of a data sheet is relative to the folder of the package's manifest"
            )
        } else {
            format!("cannot read {path}: {error}")
        };
        Error::new(file.span(), message)
    })
}

/// Constants of a data sheet, and lines of documentation about PDOs without constant.
fn of_sheet(
    sheet: &DataSheet,
    wrong: &mut dyn FnMut(&dyn std::fmt::Display),
) -> (Vec<TokenStream>, Vec<String>) {
    let values = values::of(sheet, wrong);
    let pdos = pdos::of(sheet, &values, wrong);
    let reserved = pdos.iter().map(Pdo::name).collect();
    let names = names::of(&values, reserved);
    let krate = path::canopen();
    let name = |at: (u16, u8)| values.iter().position(|value| value.at == at).map(|nth| &names[nth]);
    let mut constants: Vec<TokenStream> =
        values.iter().zip(&names).map(|(value, name)| value.constant(name, &krate)).collect();
    let mut notes = Vec::new();
    for pdo in &pdos {
        match &pdo.mapped {
            Ok(mapped) => constants.push(pdo.constant(mapped, &krate, name)),
            Err(reason) => notes.push(format!("- {}: {reason}", pdo.name())),
        }
    }
    if !notes.is_empty() {
        let heading = ["", "Valid PDOs of the data sheet without constant:", ""].map(str::to_owned);
        notes.splice(0..0, heading);
    }
    (constants, notes)
}

/// A text of a data sheet as code in documentation: no letter of it is markup.
fn quoted(text: &str) -> String {
    format!("`{}`", text.replace('`', "'"))
}
