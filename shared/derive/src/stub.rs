//! Implementations that stand beside the errors of a declaration. The compiler then shows these errors alone, and
//! no error for each use of the type.

use proc_macro2::TokenStream;
use quote::quote;
use syn::DeriveInput;

/// Returns an implementation of `Objects` without objects.
pub fn objects(input: &DeriveInput) -> TokenStream {
    let (ident, default) = (&input.ident, default(input));
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    quote! {
        impl #impl_generics ::ecss_can::od::Objects for #ident #type_generics #bounds {
            const COUNT: u16 = 0;
            const DECLARED: &'static ::ecss_can::od::Declared =
                &::ecss_can::od::Declared { objects: &[], groups: &[] };

            fn object(_: u16) -> ::core::option::Option<(&'static ::ecss_can::od::Object, u16, u16)> {
                ::core::option::Option::None
            }

            fn each_object(_: &mut dyn FnMut(&'static ::ecss_can::od::Object)) {}

            fn describe(_: &mut dyn FnMut(&'static ::ecss_can::od::Object, &'static ::ecss_can::od::Names)) {}

            fn variable(
                &mut self,
                _: ::ecss_can::od::Place,
            ) -> ::core::option::Option<&mut dyn ::ecss_can::od::Variable> {
                ::core::option::Option::None
            }

            fn bits(&self, _: ::ecss_can::od::Place, _: ::ecss_can::od::Run) -> ::core::option::Option<u64> {
                ::core::option::Option::None
            }

            fn set_bits(
                &mut self,
                _: ::ecss_can::od::Place,
                _: ::ecss_can::od::Run,
                _: u64,
            ) -> ::core::option::Option<()> {
                ::core::option::Option::None
            }
        }

        #default
    }
}

/// Returns an implementation of `Record` without entries.
pub fn record(input: &DeriveInput) -> TokenStream {
    let (ident, default) = (&input.ident, default(input));
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    quote! {
        impl #impl_generics ::ecss_can::od::Record for #ident #type_generics #bounds {
            const ENTRIES: &'static [::ecss_can::od::Entry] = &[];
            const NAMES: &'static [&'static str] = &[];

            fn variable(&mut self, _: u8) -> ::core::option::Option<&mut dyn ::ecss_can::od::Variable> {
                ::core::option::Option::None
            }
        }

        #default
    }
}

/// The build has failed: nothing calls it.
fn default(input: &DeriveInput) -> TokenStream {
    let ident = &input.ident;
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    quote! {
        impl #impl_generics ::core::default::Default for #ident #type_generics #bounds {
            fn default() -> Self {
                ::core::panic!("the declaration has errors")
            }
        }
    }
}
