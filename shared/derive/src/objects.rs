//! Expands `#[derive(Objects)]`.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{DeriveInput, Error, Field, Ident, LitInt, Path, Type};

use crate::attribute::{Attribute, Shape};
use crate::errors::Errors;
use crate::field::{self, Declared};
use crate::{instance, path};

/// An object, or several in a row.
pub struct Object<'a> {
    pub number: u16,
    pub declaration: TokenStream,
    pub names: TokenStream,
    /// Field of the struct that declares the object.
    pub field: &'a Field,
    /// The record under it, or under each in a row.
    pub record: Option<&'a Type>,
    /// Type of each value outside a record.
    pub element: &'a Type,
    /// Types that say what SDO clients may do.
    pub access_types: TokenStream,
    /// It has no other value, and is no row.
    pub is_single: bool,
    /// The value at a place, an `Option<&mut dyn Variable>`.
    pub variable: TokenStream,
    /// Expression for the value that a transmit PDO reads at a place, an `Option<u64>`. `None`: it may not.
    pub bits: Option<TokenStream>,
    /// Expression that writes the value of a receive PDO at a place, an `Option<()>`. `None`: it may not.
    pub set_bits: Option<TokenStream>,
    /// Statement that refuses a number which is no value of an enumeration. `None`: no client writes it.
    pub check: Option<TokenStream>,
}

pub fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let (mut objects, mut groups, mut initials, mut values) =
        (Vec::new(), Vec::new(), Vec::new(), TokenStream::new());
    let (mut numbers, mut errors) = (Vec::new(), Errors::default());
    for field in &crate::fields(input)?.named {
        let name = field::ident(field)?;
        let mut attribute = None;
        match errors.take(field::declared(field, "object", Some("objects"))) {
            Some(Declared::Value(value)) => attribute = Some(value),
            Some(Declared::Group) => groups.push((name, &field.ty)),
            Some(Declared::Misspelled(_)) => errors.add_silent(),
            Some(Declared::Skipped) | None => {}
        }
        let initial = field::initial(field, attribute.as_deref());
        initials.push(quote!(#name: #initial));
        if let Some(attribute) = attribute {
            values.extend(field::initial_constant(input, field, &attribute));
            numbers.extend(attribute.value(u16::MAX).map(|number| (number, attribute.number.span())));
            objects.extend(object(field, &attribute, &mut errors));
        }
    }
    errors.add_repeated(numbers, |number| format!("index {number:04X}h is declared twice"));
    objects.sort_by_key(|object| object.number);
    let options = options(input, &mut errors);
    errors.finish()?;
    values.extend(implementation(input, &objects, &groups, &initials, options));
    Ok(values)
}

/// `#[objects(check = function, device, sdo_servers = 2)]` on the whole declaration.
#[derive(Default)]
struct Options {
    /// Refuses what clients write.
    check: Option<Path>,
    /// It is the application of a device: where the word stands.
    device: Option<Span>,
    /// Number of its SDO servers, if it is declared.
    sdo_servers: Option<LitInt>,
    /// The code beside the declaration says how the device keeps the spacecraft time.
    own_time: Option<Span>,
}

impl Options {
    fn has_two_sdo_servers(&self) -> bool {
        self.sdo_servers.as_ref().is_some_and(|number| number.base10_digits() == "2")
    }
}

fn options(input: &DeriveInput, errors: &mut Errors) -> Options {
    let mut options = Options::default();
    for attribute in input.attrs.iter().filter(|attribute| attribute.path().is_ident("objects")) {
        let read = attribute.parse_nested_meta(|meta| {
            match meta.path.get_ident().map(Ident::to_string).as_deref() {
                Some("check") => options.check = Some(meta.value()?.parse()?),
                Some("device") => options.device = Some(meta.path.span()),
                Some("sdo_servers") => options.sdo_servers = Some(meta.value()?.parse()?),
                Some("time") => options.own_time = Some(meta.path.span()),
                _ => {
                    return Err(
                        meta.error("unknown word; known are `check`, `device`, `sdo_servers` and `time`")
                    );
                }
            }
            Ok(())
        });
        errors.take(read);
    }
    if let Some(number) = &options.sdo_servers {
        if options.device.is_none() {
            errors.add(Error::new(number.span(), "`sdo_servers` is for a device: add `device`"));
        } else if !matches!(number.base10_digits(), "1" | "2") {
            let message = format!("a device has 1 or 2 SDO servers, not {number}");
            errors.add(Error::new(number.span(), message));
        }
    }
    if let Some(span) = options.own_time {
        if options.device.is_none() {
            errors.add(Error::new(span, "`time` is for a device: add `device`"));
        } else if path::ecss_at(span).is_none() {
            let message = "`time` is for a device of `ecss-can`, on which this package does not depend";
            errors.add(Error::new(span, message));
        }
    }
    options
}

/// Returns whether a wrong declaration may be that of a device: it says so, or the words for it have an error.
pub fn may_be_device(input: &DeriveInput) -> bool {
    let mut errors = Errors::default();
    options(input, &mut errors).device.is_some() || errors.finish().is_err()
}

fn implementation(
    input: &DeriveInput,
    objects: &[Object<'_>],
    groups: &[(&Ident, &Type)],
    initials: &[TokenStream],
    options: Options,
) -> TokenStream {
    let krate = path::canopen();
    let own = objects.len() as u16;
    let declarations = objects.iter().map(|object| &object.declaration);
    let names = objects.iter().map(|object| &object.names);
    let numbers = 0..own;
    let variables = objects.iter().map(|object| &object.variable);
    let arm = |(number, value): (u16, &Option<TokenStream>)| {
        value.as_ref().map(|value| quote!(#number => return #value,))
    };
    let reads: Vec<_> = (0..).zip(objects.iter().map(|object| &object.bits)).filter_map(arm).collect();
    let writes: Vec<_> = (0..).zip(objects.iter().map(|object| &object.set_bits)).filter_map(arm).collect();
    let values = objects.iter().filter_map(|object| object.check.as_ref());
    let group_names: Vec<&Ident> = groups.iter().map(|(name, _)| *name).collect();
    let types: Vec<&Type> = groups.iter().map(|(_, group)| *group).collect();
    let check = options.check.map(|function| quote!(#function(self, at, value)?;));
    let ident = &input.ident;
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    let constants: Vec<_> =
        (0..).zip(objects).filter_map(|(nth, object)| constant(input, nth, object)).collect();
    let constants = instance::constants(input, &constants);
    let (mut asserted, mut in_default) = instance::assertion(input, ident.span(), |this| {
        let krate = path::canopen_at(ident.span());
        quote_spanned!(ident.span()=> <#this as #krate::od::Objects>::DECLARED.assert_distinct())
    });
    let mut marked = TokenStream::new();
    if let Some(span) = options.device {
        marked = device(input);
        let (beside, inside) = instance::assertion(input, span, |this| {
            let krate = path::ecss_at(span).unwrap_or_else(|| path::canopen_at(span));
            quote_spanned!(span=> #krate::node::assert_device::<#this>())
        });
        asserted.extend(beside);
        in_default.extend(inside);
    }
    quote! {
        #asserted

        #marked

        #constants

        impl #impl_generics #krate::od::Objects for #ident #type_generics #bounds {
            const COUNT: u16 = #own #(+ <#types as #krate::od::Objects>::COUNT)*;
            const DECLARED: &'static #krate::od::Declared = &#krate::od::Declared {
                objects: &[#(#declarations),*],
                groups: &[#(<#types as #krate::od::Objects>::DECLARED),*],
            };

            fn describe(
                visit: &mut dyn FnMut(&'static #krate::od::Object, &'static #krate::od::Names),
            ) {
                let names: &'static [#krate::od::Names] = const { &[#(#names),*] };
                for (object, names) in Self::DECLARED.objects.iter().zip(names) {
                    visit(object, names);
                }
                #(<#types as #krate::od::Objects>::describe(visit);)*
            }

            #[allow(unused_variables, unused_mut, unused_assignments)]
            fn variable(
                &mut self,
                mut place: #krate::od::Place,
            ) -> ::core::option::Option<&mut dyn #krate::od::Variable> {
                match place.object {
                    #(#numbers => return #variables,)*
                    _ => {}
                }
                place.object -= #own;
                #(
                    if place.object < <#types as #krate::od::Objects>::COUNT {
                        return #krate::od::Objects::variable(&mut self.#group_names, place);
                    }
                    place.object -= <#types as #krate::od::Objects>::COUNT;
                )*
                ::core::option::Option::None
            }

            #[allow(unused_variables)]
            #[inline]
            fn check(
                &self,
                at: #krate::types::Address,
                value: &[u8],
            ) -> ::core::result::Result<(), #krate::types::AbortCode> {
                #(#values)*
                #check
                #(<#types as #krate::od::Objects>::check(&self.#group_names, at, value)?;)*
                ::core::result::Result::Ok(())
            }

            #[allow(unused_variables, unused_mut, unused_assignments)]
            #[inline]
            fn bits(
                &self,
                mut place: #krate::od::Place,
                run: #krate::od::Run,
            ) -> ::core::option::Option<u64> {
                match place.object {
                    #(#reads)*
                    _ => {}
                }
                place.object = place.object.wrapping_sub(#own);
                #(
                    if place.object < <#types as #krate::od::Objects>::COUNT {
                        return #krate::od::Objects::bits(&self.#group_names, place, run);
                    }
                    place.object = place.object.wrapping_sub(<#types as #krate::od::Objects>::COUNT);
                )*
                ::core::option::Option::None
            }

            #[allow(unused_variables, unused_mut, unused_assignments)]
            #[inline]
            fn set_bits(
                &mut self,
                mut place: #krate::od::Place,
                run: #krate::od::Run,
                bits: u64,
            ) -> ::core::option::Option<()> {
                match place.object {
                    #(#writes)*
                    _ => {}
                }
                place.object = place.object.wrapping_sub(#own);
                #(
                    if place.object < <#types as #krate::od::Objects>::COUNT {
                        return #krate::od::Objects::set_bits(&mut self.#group_names, place, run, bits);
                    }
                    place.object = place.object.wrapping_sub(<#types as #krate::od::Objects>::COUNT);
                )*
                ::core::option::Option::None
            }
        }

        impl #impl_generics ::core::default::Default for #ident #type_generics #bounds {
            fn default() -> Self {
                #in_default
                Self { #(#initials),* }
            }
        }
    }
}

/// Returns what makes the declaration that of a device, with `ecss-can` also of a device for a spacecraft.
pub fn device(input: &DeriveInput) -> TokenStream {
    let krate = path::canopen();
    let options = options(input, &mut Errors::default());
    let sdo = if options.has_two_sdo_servers() { quote!(TwoSdoServers) } else { quote!(SdoServerObjects) };
    let ident = &input.ident;
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    let ecss = path::ecss_at(Span::call_site()).filter(|_| options.own_time.is_none());
    let spacecraft = ecss.map(|ecss| {
        quote! {
            #[diagnostic::do_not_recommend]
            impl #impl_generics #ecss::node::DeviceTime for #ident #type_generics #bounds {}
        }
    });
    quote! {
        #[diagnostic::do_not_recommend]
        impl #impl_generics #krate::node::DeviceObjects for #ident #type_generics #bounds {
            type Sdo = #krate::sdo::#sdo;
        }

        #spacecraft
    }
}

/// The constant of the field of an object, the `nth` of those declared.
pub fn constant(input: &DeriveInput, nth: usize, object: &Object) -> Option<TokenStream> {
    let krate = path::canopen();
    let kind = if object.is_single { quote!(#krate::od::Field) } else { quote!(#krate::od::Fields) };
    let filled = |of: &Type| instance::filled(input, of.to_token_stream());
    let (element, access) = (filled(object.element), &object.access_types);
    let of = match (object.record.map(filled), object.is_single) {
        (_, true) => quote!(#kind<#element, #access>),
        (Some(record), _) => quote!(#kind<#record>),
        (None, _) => quote!(#kind<(), #element, #access>),
    };
    let value = quote!(#kind::of(&<Self as #krate::od::Objects>::DECLARED.objects[#nth]));
    field::constant(object.field, &format!("{:04X}h", object.number), &of, &value)
}

/// Returns the type of each value of an object, as far as it is known.
pub fn element<'a>(value: &'a Type, attribute: &Attribute) -> &'a Type {
    match value {
        Type::Array(array) if attribute.shape == Shape::Array => &array.elem,
        _ => value,
    }
}

/// `None` after an error.
pub fn object<'a>(field: &'a Field, attribute: &Attribute, errors: &mut Errors) -> Option<Object<'a>> {
    let krate = path::canopen();
    let (title, number) = (field::title(field), attribute.value(u16::MAX));
    let (title, number) = (errors.take(title), errors.take(number));
    // The type of one object of several in a row, how many there are, and the one meant.
    let name = &field.ident;
    let one = if attribute.in_a_row {
        let nth = quote!(::core::primitive::usize::from(place.instance));
        errors.take(field::array(field)).map(|array| {
            let (value, len) = (&*array.elem, &array.len);
            (value, quote!((#len) as u16), quote!(self.#name.get(#nth)?), quote!(self.#name.get_mut(#nth)?))
        })
    } else {
        Some((&field.ty, quote!(1), quote!((&self.#name)), quote!((&mut self.#name))))
    };
    let title_text = title.as_deref().unwrap_or_default();
    let parts = one.and_then(|(value, count, place, place_mut)| {
        let parts = match attribute.shape {
            Shape::Var => var(&field.ty, value, attribute, title_text, &place, &place_mut, errors),
            Shape::Array => array(&field.ty, value, attribute, title_text, &place, &place_mut, errors),
            Shape::Record { as_array } => Some(record(value, as_array, &place, &place_mut)),
        };
        parts.map(|parts| (parts, value, count))
    });
    let (title, number, (parts, value, count)) = (title?, number?, parts?);
    let Parts { code, entries, names, values, structure, variable, bits, set_bits } = parts;
    let (read, written) = match attribute.shape {
        // Its entries know.
        Shape::Record { .. } => (true, true),
        Shape::Var | Shape::Array => attribute.directions(),
    };
    let declaration = quote! {
        #krate::od::Object { index: #number, count: #count, entries: #entries }
    };
    let names = quote! {
        #krate::od::Names {
            code: #code, object: #title, entries: #names, values: #values, structure: #structure,
        }
    };
    let (bits, set_bits) = (read.then_some(bits), written.then_some(set_bits));
    let record = matches!(attribute.shape, Shape::Record { .. }).then_some(value);
    let is_single = attribute.shape == Shape::Var && !attribute.in_a_row;
    let (element, access_types) = (element(value, attribute), attribute.access_types());
    let is_meant = quote!(at.index.wrapping_sub(#number) < #count);
    let check = match record {
        Some(record) => Some(quote! {
            if #is_meant {
                <#record as #krate::od::Record>::check(at.sub, value)?;
            }
        }),
        None => attribute.is_writable().then(|| field::check(&is_meant, element)),
    };
    Some(Object {
        number,
        declaration,
        names,
        field,
        record,
        element,
        access_types,
        is_single,
        variable,
        bits,
        set_bits,
        check,
    })
}

/// Expressions that depend on the shape of an object.
struct Parts {
    code: TokenStream,
    entries: TokenStream,
    names: TokenStream,
    values: TokenStream,
    structure: TokenStream,
    variable: TokenStream,
    bits: TokenStream,
    set_bits: TokenStream,
}

fn var(
    of: &Type,
    value: &Type,
    attribute: &Attribute,
    title: &str,
    place: &TokenStream,
    place_mut: &TokenStream,
    errors: &mut Errors,
) -> Option<Parts> {
    let krate = path::canopen();
    let access = errors.take(attribute.required_access())?;
    let (same_error, named) = (field::same_error(value), field::named(value));
    let entry = attribute.qualified(of, quote!(#krate::od::Entry::of::<#value>(0, 1, #access)));
    Some(Parts {
        code: quote! {
            match #krate::od::Entry::of::<#value>(0, 1, #access).data_type {
                #krate::od::DataType::Domain => #krate::od::ObjectCode::Domain,
                _ => #krate::od::ObjectCode::Var,
            }
        },
        entries: quote!(&[#entry]),
        names: quote!(&[#title]),
        values: quote!(&[#named]),
        structure: quote!(0),
        variable: quote!({
            #same_error
            ::core::option::Option::Some(<#value as #krate::od::Typed>::as_variable(#place_mut))
        }),
        bits: field::bits(place, value),
        set_bits: field::set_bits(place_mut, value, attribute),
    })
}

fn array(
    of: &Type,
    value: &Type,
    attribute: &Attribute,
    title: &str,
    place: &TokenStream,
    place_mut: &TokenStream,
    errors: &mut Errors,
) -> Option<Parts> {
    let krate = path::canopen();
    let access = errors.take(attribute.required_access());
    let Type::Array(array) = value else {
        errors.add(Error::new_spanned(value, "an ARRAY object needs an array"));
        return None;
    };
    let (value, count) = (&*array.elem, field::sub_indices(&array.len));
    let access = access?;
    let entry = attribute.qualified(of, quote!(#krate::od::Entry::of::<#value>(1, #count, #access)));
    let nth = quote!(::core::primitive::usize::from(place.sub).wrapping_sub(1));
    let (same_error, named) = (field::same_error(value), field::named(value));
    // At the place of the type: the error that it is no `Variable` follows from that of its declaration.
    let found = Ident::new("found", value.span());
    Some(Parts {
        code: quote!(#krate::od::ObjectCode::Array),
        entries: quote!(&[#krate::od::Entry::highest(#count), #entry]),
        names: quote!(&["Highest sub-index supported", #title]),
        values: quote!(&[&[], #named]),
        structure: quote!(0),
        variable: quote!({
            #same_error
            match #place_mut.get_mut(#nth) {
                ::core::option::Option::Some(#found) => ::core::option::Option::Some(#found),
                ::core::option::Option::None => ::core::option::Option::None,
            }
        }),
        bits: field::run_bits(place, &nth, value),
        set_bits: field::set_run_bits(place_mut, &nth, value, attribute),
    })
}

fn record(value: &Type, as_array: bool, place: &TokenStream, place_mut: &TokenStream) -> Parts {
    let krate = path::canopen();
    let code = if as_array { quote!(Array) } else { quote!(Record) };
    Parts {
        code: quote!(#krate::od::ObjectCode::#code),
        entries: quote!(<#value as #krate::od::Record>::ENTRIES),
        names: quote!(<#value as #krate::od::Record>::NAMES),
        values: quote!(<#value as #krate::od::Record>::VALUES),
        structure: quote!(<#value as #krate::od::Record>::STRUCTURE),
        variable: quote!(#krate::od::Record::variable(#place_mut, place.sub)),
        bits: quote!(#krate::od::Record::bits(#place, place.sub, run)),
        set_bits: quote!(#krate::od::Record::set_bits(#place_mut, place.sub, run, bits)),
    }
}
