//! The no-panic program calls everything that model-core offers: `cargo xtask no-panic` proves something only of what
//! it calls.
//!
//! Both are read as source: what is public in model-core without its features `host` and `methods`, and which paths the
//! program's functions name. What the program leaves out stands in its `excluded.toml` with a reason.

use proc_macro2::{Group, TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::Visit;
use syn::{Attribute, ExprPath, ImplItem, Item, ItemFn, ItemMacro, Meta, Type, Visibility};

/// Which function of the program calls what a derive makes, and the derives that make nothing.
const DERIVES: [(&str, Option<&str>); 9] = [
    ("Clone", Some("cloned")),
    ("PartialEq", Some("compared")),
    ("PartialOrd", Some("ordered")),
    ("Ord", Some("ordered")),
    ("Hash", Some("hashed")),
    ("Serialize", Some("coded")),
    ("Deserialize", Some("coded")),
    ("Copy", None),
    ("Eq", None),
];

/// The program's functions that stand for several: see its `derived.rs`.
const SEVERAL: [(&str, &[&str]); 2] =
    [("plain", &["cloned", "compared"]), ("message", &["cloned", "compared", "coded"])];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate lies in the workspace").to_path_buf()
}

fn parse(path: &Path) -> syn::File {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Whether an item is there in the board's build: neither `test` nor any feature.
fn compiled(attributes: &[Attribute]) -> bool {
    fn holds(meta: &Meta) -> bool {
        let all = |meta: &Meta| -> Vec<bool> {
            let Meta::List(list) = meta else { panic!("cfg: {}", meta.to_token_stream()) };
            let parser = syn::punctuated::Punctuated::<Meta, syn::Token![,]>::parse_terminated;
            list.parse_args_with(parser).expect("cfg predicates").iter().map(holds).collect()
        };
        match meta.path().require_ident().expect("a cfg predicate").to_string().as_str() {
            "test" | "feature" => false,
            "not" => !all(meta).contains(&true),
            "any" => all(meta).contains(&true),
            "all" => !all(meta).contains(&false),
            other => panic!("cfg({other}): teach this test whether the board's build has it"),
        }
    }
    let cfgs = attributes.iter().filter(|attribute| attribute.path().is_ident("cfg"));
    cfgs.map(|cfg| cfg.parse_args::<Meta>().expect("a cfg predicate")).all(|meta| holds(&meta))
}

fn tokens_without_spaces(tokens: impl ToTokens) -> String {
    tokens.to_token_stream().to_string().replace(' ', "")
}

/// A type's name without module and arguments.
fn type_name(kind: &Type) -> String {
    let Type::Path(path) = kind else { panic!("{}: not a named type", kind.to_token_stream()) };
    path.path.segments.last().expect("a path has segments").ident.to_string()
}

/// What model-core offers, as the program has to name it: `Type::method`, `module::function`, `<Type as Trait>::method`,
/// and `function::<Type>` for a derive.
#[derive(Default)]
struct Offer {
    names: BTreeSet<String>,
    debug_types: usize,
}

impl Offer {
    fn read(file: &Path, module: &str) -> Self {
        let mut offer = Self::default();
        offer.walk(&parse(file).items, module, file.parent().expect("a file lies in a folder"));
        offer
    }

    fn walk(&mut self, items: &[Item], module: &str, folder: &Path) {
        let mut macros = BTreeMap::new();
        for item in items {
            match item {
                Item::Mod(inner) if compiled(&inner.attrs) && is_public(&inner.vis) => self.submodule(inner, folder),
                Item::Mod(inner) if compiled(&inner.attrs) => self.reexported(inner, items, folder),
                Item::Fn(function) if is_public(&function.vis) && compiled(&function.attrs) => {
                    self.names.insert(format!("{module}::{}", function.sig.ident));
                }
                Item::Impl(block) if compiled(&block.attrs) => self.block(block, items),
                Item::Struct(item) if is_public(&item.vis) && compiled(&item.attrs) => {
                    self.derives(&item.ident.to_string(), &item.attrs);
                }
                Item::Enum(item) if is_public(&item.vis) && compiled(&item.attrs) => {
                    self.derives(&item.ident.to_string(), &item.attrs);
                }
                Item::Macro(item) if compiled(&item.attrs) => match &item.ident {
                    Some(name) => drop(macros.insert(name.to_string(), item.mac.tokens.clone())),
                    None => self.walk(&expand(item, &macros), module, folder),
                },
                Item::Trait(item) => assert!(!is_public(&item.vis), "{}: teach this test about traits", item.ident),
                _ => {}
            }
        }
    }

    /// What `pub use` offers of a private module beside it: types by their names.
    fn reexported(&mut self, inner: &syn::ItemMod, items: &[Item], folder: &Path) {
        let shown = items.iter().filter_map(|item| match item {
            Item::Use(item) if is_public(&item.vis) => match &item.tree {
                syn::UseTree::Path(path) if path.ident == inner.ident => match &*path.tree {
                    syn::UseTree::Name(name) => Some(name.ident.to_string()),
                    other => panic!("{}: teach this test about such a `pub use`", other.to_token_stream()),
                },
                _ => None,
            },
            _ => None,
        });
        let mut hidden = Self::default();
        hidden.submodule(inner, folder);
        for name in shown {
            let of_it = |text: &&String| text.split(|c: char| !c.is_alphanumeric()).any(|word| word == name);
            let names: Vec<_> = hidden.names.iter().filter(of_it).cloned().collect();
            assert!(!names.is_empty(), "{name}: teach this test where it comes from");
            self.names.extend(names);
            self.debug_types += hidden.debug_types;
        }
    }

    fn submodule(&mut self, inner: &syn::ItemMod, folder: &Path) {
        let name = inner.ident.to_string();
        if let Some((_, items)) = &inner.content {
            self.walk(items, &name, &folder.join(&name));
            return;
        }
        let (file, own) = (folder.join(format!("{name}.rs")), folder.join(&name));
        let file = if file.exists() { file } else { own.join("mod.rs") };
        self.walk(&parse(&file).items, &name, &own);
    }

    fn block(&mut self, block: &syn::ItemImpl, items: &[Item]) {
        let kind = type_name(&block.self_ty);
        let private = items.iter().any(|item| match item {
            Item::Struct(item) => item.ident == kind && !is_public(&item.vis),
            Item::Enum(item) => item.ident == kind && !is_public(&item.vis),
            _ => false,
        });
        if private {
            return;
        }
        for item in &block.items {
            let ImplItem::Fn(function) = item else { continue };
            let name = &function.sig.ident;
            match &block.trait_ {
                Some((_, path, _)) => {
                    let of = tokens_without_spaces(path.segments.last());
                    self.names.insert(format!("<{kind} as {of}>::{name}"));
                }
                None if is_public(&function.vis) && compiled(&function.attrs) => {
                    self.names.insert(format!("{kind}::{name}"));
                }
                None => {}
            }
        }
    }

    fn derives(&mut self, kind: &str, attributes: &[Attribute]) {
        for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("derive")) {
            let add = |meta: syn::meta::ParseNestedMeta<'_>| {
                let of = meta.path.segments.last().expect("a path has segments").ident.to_string();
                match of.as_str() {
                    "Debug" => self.debug_types += 1,
                    "Default" => drop(self.names.insert(format!("<{kind} as Default>::default"))),
                    other => {
                        let known = DERIVES.iter().find(|(name, _)| *name == other);
                        let (_, caller) = known.unwrap_or_else(|| panic!("{kind}: teach this test to derive {other}"));
                        self.names.extend(caller.map(|caller| format!("{caller}::<{kind}>")));
                    }
                }
                Ok(())
            };
            attribute.parse_nested_meta(add).expect("a list of traits");
        }
    }
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_punct(token: Option<&TokenTree>, character: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == character)
}

/// The items that a call of a macro of one rule makes. Its repetitions (of documentation) are left out.
fn expand(call: &ItemMacro, macros: &BTreeMap<String, TokenStream>) -> Vec<Item> {
    let name = tokens_without_spaces(&call.mac.path);
    let rule = macros.get(&name).unwrap_or_else(|| panic!("{name}!: not a macro of the same file"));
    let groups: Vec<Group> = rule
        .clone()
        .into_iter()
        .filter_map(|token| match token {
            TokenTree::Group(group) => Some(group),
            _ => None,
        })
        .collect();
    let [matcher, body] = groups.as_slice() else { panic!("{name}!: teach this test about macros of several rules") };
    let matcher: Vec<TokenTree> = matcher.stream().into_iter().collect();
    let names = matcher.windows(3).filter(|window| is_punct(window.first(), '$') && is_punct(window.get(2), ':'));
    let names = names.map(|window| window[1].to_string());
    let mut arguments = vec![TokenStream::new()];
    let mut tokens = call.mac.tokens.clone().into_iter().peekable();
    while let Some(token) = tokens.next() {
        if is_punct(Some(&token), '#') {
            tokens.next();
        } else if is_punct(Some(&token), ',') {
            arguments.push(TokenStream::new());
        } else {
            arguments.last_mut().expect("never empty").extend([token]);
        }
    }
    let bound: BTreeMap<String, TokenStream> = names.zip(arguments).collect();
    let file: syn::File =
        syn::parse2(substitute(body.stream(), &bound)).unwrap_or_else(|error| panic!("{name}!: {error}"));
    file.items
}

fn substitute(tokens: TokenStream, bound: &BTreeMap<String, TokenStream>) -> TokenStream {
    let mut result = TokenStream::new();
    let mut tokens = tokens.into_iter();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Punct(punct) if punct.as_char() == '$' => match tokens.next() {
                Some(TokenTree::Group(_)) => drop(tokens.next()),
                Some(TokenTree::Ident(name)) => {
                    let tokens = bound.get(&name.to_string()).unwrap_or_else(|| panic!("${name} is bound to nothing"));
                    result.extend(tokens.clone());
                }
                _ => panic!("a $ without a name"),
            },
            TokenTree::Group(group) => {
                let inner = substitute(group.stream(), bound);
                result.extend([TokenTree::Group(Group::new(group.delimiter(), inner))]);
            }
            token => result.extend([token]),
        }
    }
    result
}

/// The paths that the bodies of functions name, in the form of [`Offer::names`].
#[derive(Default)]
struct Calls(BTreeSet<String>);

impl<'ast> Visit<'ast> for Calls {
    fn visit_item_fn(&mut self, function: &'ast ItemFn) {
        struct Paths<'a>(&'a mut BTreeSet<String>);
        impl<'ast> Visit<'ast> for Paths<'_> {
            fn visit_expr_path(&mut self, path: &'ast ExprPath) {
                self.0.extend(names(path));
                syn::visit::visit_expr_path(self, path);
            }
        }
        Paths(&mut self.0).visit_block(&function.block);
    }
}

fn names(path: &ExprPath) -> Vec<String> {
    let segments: Vec<_> = path.path.segments.iter().collect();
    match (&path.qself, segments.as_slice()) {
        (Some(kind), [.., of, function]) => {
            vec![format!("<{} as {}>::{}", type_name(&kind.ty), tokens_without_spaces(of), function.ident)]
        }
        (None, [.., owner, function]) => vec![format!("{}::{}", owner.ident, function.ident)],
        (None, [function]) => {
            let syn::PathArguments::AngleBracketed(arguments) = &function.arguments else { return Vec::new() };
            let Some(syn::GenericArgument::Type(kind)) = arguments.args.first() else { return Vec::new() };
            let name = function.ident.to_string();
            let several = SEVERAL.iter().find(|(several, _)| *several == name);
            let each = several.map_or(vec![name.as_str()], |(_, each)| each.to_vec());
            let kind = if let Type::Path(_) = kind { type_name(kind) } else { return Vec::new() };
            each.into_iter().map(|function| format!("{function}::<{kind}>")).collect()
        }
        _ => Vec::new(),
    }
}

fn calls() -> BTreeSet<String> {
    let mut calls = Calls::default();
    for file in ["calls.rs", "derived.rs"] {
        calls.visit_file(&parse(&root().join("tests/no-panic/src").join(file)));
    }
    calls.0
}

fn exclusions() -> BTreeMap<String, String> {
    let path = root().join("tests/no-panic/excluded.toml");
    toml::from_str(&std::fs::read_to_string(path).expect("the list is there")).expect("names and reasons")
}

#[test]
fn the_no_panic_program_calls_everything_that_model_core_offers() {
    let offer = Offer::read(&root().join("model-core/src/lib.rs"), "model_core");
    let (calls, excluded) = (calls(), exclusions());
    let missing: Vec<_> =
        offer.names.iter().filter(|name| !calls.contains(*name) && !excluded.contains_key(*name)).collect();
    assert!(
        missing.is_empty(),
        "tests/no-panic/src does not call: {missing:#?}\nname each by its path there, or add it to excluded.toml with the reason"
    );
    println!("{} functions, {} left out", offer.names.len(), excluded.len());
}

#[test]
fn what_is_left_out_exists_and_is_not_called() {
    let offer = Offer::read(&root().join("model-core/src/lib.rs"), "model_core");
    let calls = calls();
    for (name, reason) in exclusions() {
        assert!(!calls.contains(&name), "{name} is called: take it off excluded.toml");
        assert!(offer.names.contains(&name) || name == "Debug" && offer.debug_types > 0, "{name} does not exist");
        assert!(reason.len() > 20, "{name} needs a reason");
    }
}

/// The reader itself: it sees what it must, through macros, features and modules, and nothing else.
#[test]
fn the_reader_sees_what_is_public() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("writes");
    write(
        "lib.rs",
        r#"
        pub mod inner;
        #[cfg(feature = "host")]
        pub mod host_only;
        macro_rules! quantity {
            ($(#[$doc:meta])* $name:ident, $unit:literal, $make:ident) => {
                $(#[$doc])*
                #[derive(Clone, Debug, Default)]
                pub struct $name(i32);
                impl $name {
                    #[doc = $unit]
                    pub const fn $make() -> Self { Self(0) }
                    fn hidden() {}
                    #[cfg(any(test, feature = "host"))]
                    pub fn host() {}
                }
                impl Add for $name { fn add(self, other: Self) -> Self { self } }
            };
        }
        quantity!(
            /// Documentation, with a comma.
            Mass, "kg", from_kg
        );
        pub(crate) fn crate_only() {}
        "#,
    );
    write(
        "inner.rs",
        r#"
        pub fn free() {}
        struct Private;
        impl Private { pub fn unreachable() {} }
        pub enum Shown<T> { A(T) }
        impl<T> Shown<T> {
            pub fn map(self) {}
            #[cfg(not(feature = "host"))]
            pub fn board_only() {}
        }
        impl From<Mass> for Shown<Mass> { fn from(mass: Mass) -> Self { Self::A(mass) } }
        #[cfg(test)]
        mod tests { pub fn never() {} }
        "#,
    );
    let offer = Offer::read(&folder.path().join("lib.rs"), "lib");
    let expected = [
        "<Mass as Add>::add",
        "<Mass as Default>::default",
        "<Shown as From<Mass>>::from",
        "Mass::from_kg",
        "Shown::board_only",
        "Shown::map",
        "cloned::<Mass>",
        "inner::free",
    ];
    assert_eq!(offer.names.iter().map(String::as_str).collect::<Vec<_>>(), expected);
    assert_eq!(offer.debug_types, 1);
}
