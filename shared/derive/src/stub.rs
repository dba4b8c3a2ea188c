//! Implementations that stand beside the errors of a declaration. The compiler then shows these errors alone, and
//! no error for each use of the type: its constants, its objects in a PDO, its fields.

use proc_macro2::TokenStream;
use quote::quote;
use syn::DeriveInput;

use crate::objects::{constant, device, may_be_device};
use crate::{instance, path, sketch};

/// Returns an implementation of `Objects` that declares [sketches](sketch) and has no values.
pub fn objects(input: &DeriveInput) -> TokenStream {
    let krate = path::canopen();
    let (ident, default) = (&input.ident, default(input));
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    let (objects, groups) = sketch::objects(input);
    let constants = (0..).zip(&objects).filter_map(|(nth, object)| constant(input, nth, object));
    let constants = instance::constants(input, &constants.collect::<Vec<_>>());
    let declarations = objects.iter().map(|object| &object.declaration);
    let marked = may_be_device(input).then(|| device(input));
    quote! {
        #constants

        #marked

        impl #impl_generics #krate::od::Objects for #ident #type_generics #bounds {
            const COUNT: u16 = 0;
            const DECLARED: &'static #krate::od::Declared =
                &#krate::od::Declared {
                    objects: &[#(#declarations),*],
                    groups: &[#(<#groups as #krate::od::Objects>::DECLARED),*],
                };

            fn object(_: u16) -> ::core::option::Option<(&'static #krate::od::Object, u16, u16)> {
                ::core::option::Option::None
            }

            fn each_object(_: &mut dyn FnMut(&'static #krate::od::Object)) {}

            fn describe(_: &mut dyn FnMut(&'static #krate::od::Object, &'static #krate::od::Names)) {}

            fn variable(
                &mut self,
                _: #krate::od::Place,
            ) -> ::core::option::Option<&mut dyn #krate::od::Variable> {
                ::core::option::Option::None
            }

            fn bits(&self, _: #krate::od::Place, _: #krate::od::Run) -> ::core::option::Option<u64> {
                ::core::option::Option::None
            }

            fn set_bits(
                &mut self,
                _: #krate::od::Place,
                _: #krate::od::Run,
                _: u64,
            ) -> ::core::option::Option<()> {
                ::core::option::Option::None
            }
        }

        #default
    }
}

/// Returns an implementation of `Record` that declares [sketches](sketch) and has no values.
pub fn record(input: &DeriveInput) -> TokenStream {
    let krate = path::canopen();
    let (ident, default) = (&input.ident, default(input));
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    let mut subs = sketch::subs(input);
    let constants: Vec<_> = subs.iter_mut().filter_map(|sub| sub.constant.take()).collect();
    let constants = instance::constants(input, &constants);
    let entries = subs.iter().map(|sub| &sub.entry);
    quote! {
        #constants

        impl #impl_generics #krate::od::Record for #ident #type_generics #bounds {
            const ENTRIES: &'static [#krate::od::Entry] = &[#(#entries),*];
            const NAMES: &'static [&'static str] = &[];

            fn variable(&mut self, _: u8) -> ::core::option::Option<&mut dyn #krate::od::Variable> {
                ::core::option::Option::None
            }
        }

        #default
    }
}

/// The check has failed: nothing calls it. Should the compiler accept a misspelled attribute, because something else
/// has that name, the constant stops the build of the program. It is in a generic function: a check leaves it out.
fn default(input: &DeriveInput) -> TokenStream {
    let ident = &input.ident;
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    quote! {
        impl #impl_generics ::core::default::Default for #ident #type_generics #bounds {
            fn default() -> Self {
                fn refuse<T>() -> T {
                    const { ::core::panic!("the declaration of this type has errors") }
                }
                refuse()
            }
        }
    }
}
