//! The `# Timing` sections of a file, with the items that they belong to.

use std::path::{Path, PathBuf};

use syn::parse::{Parse, ParseStream};
use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, ExprLit, Ident, ImplItem, Item, Lit, Meta, TraitItem, Type};

use super::Promise;

/// Walks a file.
pub(super) struct Collector {
    file: PathBuf,
    path: Vec<String>,
    found: Vec<Promise>,
}

impl Collector {
    pub(super) fn collect(parsed: &syn::File, module: Vec<String>, file: &Path) -> Vec<Promise> {
        let mut collector = Self { file: file.to_owned(), path: module, found: Vec::new() };
        collector.look(None, &parsed.attrs);
        collector.visit_file(parsed);
        collector.found
    }

    fn look(&mut self, name: Option<&Ident>, attributes: &[Attribute]) {
        let Some((says, line)) = timing(attributes) else { return };
        let mut item = self.path.clone();
        item.extend(name.map(ToString::to_string));
        self.found.push(Promise { item: item.join("::"), file: self.file.clone(), line, says });
    }

    fn inside(&mut self, name: String, walk: impl FnOnce(&mut Self)) {
        self.path.push(name);
        walk(self);
        self.path.pop();
    }
}

impl<'ast> Visit<'ast> for Collector {
    fn visit_item(&mut self, item: &'ast Item) {
        match item {
            Item::Fn(it) => self.look(Some(&it.sig.ident), &it.attrs),
            Item::Struct(it) => self.look(Some(&it.ident), &it.attrs),
            Item::Enum(it) => self.look(Some(&it.ident), &it.attrs),
            Item::Type(it) => self.look(Some(&it.ident), &it.attrs),
            Item::Trait(it) => self.look(Some(&it.ident), &it.attrs),
            Item::Macro(it) => {
                if let Some(name) = &it.ident {
                    self.look(Some(name), &it.attrs);
                }
                if let Ok(parsed) = it.mac.parse_body::<Items>() {
                    parsed.0.iter().for_each(|item| self.visit_item(item));
                }
            }
            _ => {}
        }
        match item {
            Item::Mod(it) => {
                self.look(Some(&it.ident), &it.attrs);
                self.inside(it.ident.to_string(), |this| visit::visit_item(this, item));
            }
            Item::Trait(it) => {
                self.inside(it.ident.to_string(), |this| visit::visit_item(this, item));
            }
            Item::Impl(it) => {
                self.inside(type_name(&it.self_ty), |this| visit::visit_item(this, item));
            }
            _ => visit::visit_item(self, item),
        }
    }

    fn visit_impl_item(&mut self, item: &'ast ImplItem) {
        match item {
            ImplItem::Fn(it) => self.look(Some(&it.sig.ident), &it.attrs),
            ImplItem::Macro(it) => {
                if let Ok(parsed) = it.mac.parse_body::<ImplItems>() {
                    parsed.0.iter().for_each(|item| self.visit_impl_item(item));
                }
            }
            _ => {}
        }
    }

    fn visit_trait_item(&mut self, item: &'ast TraitItem) {
        if let TraitItem::Fn(it) = item {
            self.look(Some(&it.sig.ident), &it.attrs);
        }
    }
}

/// What a macro was given, where that is items.
struct Items(Vec<Item>);

impl Parse for Items {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut items = Vec::new();
        while !input.is_empty() {
            items.push(input.parse()?);
        }
        Ok(Self(items))
    }
}

/// What a macro was given inside an `impl`.
struct ImplItems(Vec<ImplItem>);

impl Parse for ImplItems {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut items = Vec::new();
        while !input.is_empty() {
            items.push(input.parse()?);
        }
        Ok(Self(items))
    }
}

fn type_name(of: &Type) -> String {
    match of {
        Type::Path(path) => {
            path.path.segments.last().map_or_else(String::new, |last| last.ident.to_string())
        }
        Type::Reference(reference) => type_name(&reference.elem),
        _ => "_".to_owned(),
    }
}

/// The first sentence under `# Timing`, and the line of the heading.
fn timing(attributes: &[Attribute]) -> Option<(String, usize)> {
    let mut lines = attributes.iter().filter_map(doc);
    let (_, line) = lines.find(|(text, _)| text.trim() == "# Timing")?;
    let section: Vec<_> = lines
        .map(|(text, _)| text.trim().to_owned())
        .skip_while(String::is_empty)
        .take_while(|text| !text.is_empty() && !text.starts_with('#'))
        .collect();
    let section = section.join(" ");
    let end = section.find(". ").map_or(section.len(), |at| at + 1);
    Some((section.get(..end).unwrap_or(&section).to_owned(), line))
}

fn doc(attribute: &Attribute) -> Option<(String, usize)> {
    let Meta::NameValue(pair) = &attribute.meta else { return None };
    if !attribute.path().is_ident("doc") {
        return None;
    }
    match &pair.value {
        Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => {
            Some((text.value(), attribute.span().start().line))
        }
        _ => None,
    }
}
