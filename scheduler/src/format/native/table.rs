//! A table that is being read: which keys are known, and what is wrong with
//! their values.

use core::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::format::diagnostic::Rule;
use crate::format::native::value;
use crate::format::suggest;
use crate::format::wrong::{Report, Wrong, shown};

/// A value and where it stands.
pub(crate) type Value<'t> = (&'t DeValue<'t>, Range<usize>);

/// A table of a file that is being read.
pub(crate) struct Table<'t, 'r, 's> {
    table: &'t DeTable<'t>,
    pub(crate) at: Range<usize>,
    /// Its name with a point at the end, to say which field of what is wrong;
    /// empty for tasks, whose fields are columns elsewhere.
    prefix: &'static str,
    pub(crate) report: &'r mut Report<'s>,
}

impl<'t, 'r, 's> Table<'t, 'r, 's> {
    pub(crate) const fn new(
        table: &'t DeTable<'t>,
        at: Range<usize>,
        prefix: &'static str,
        report: &'r mut Report<'s>,
    ) -> Self {
        Self { table, at, prefix, report }
    }

    /// The value of a key.
    pub(crate) fn value(&self, key: &str) -> Option<Value<'t>> {
        self.table.get(key).map(|value| (value.get_ref(), value.span()))
    }

    /// Where a key's value stands, or the table where it has none.
    pub(crate) fn span(&self, key: &str) -> Range<usize> {
        self.table.get(key).map_or_else(|| self.at.clone(), Spanned::span)
    }

    /// Which of these keys are there, in the order in which they stand.
    pub(crate) fn present(&self, keys: &[&'static str]) -> Vec<&'static str> {
        let mut there: Vec<_> =
            keys.iter().copied().filter(|key| self.table.contains_key(*key)).collect();
        there.sort_by_key(|key| self.span(key).start);
        there
    }

    /// Reads a value, if the key is there; tells what is wrong with it.
    pub(crate) fn read<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&'t DeValue<'t>) -> Result<T, Wrong>,
    ) -> Option<T> {
        let (value, at) = self.value(key)?;
        let field = self.field(key);
        self.report.take(at, &field, read(value))
    }

    /// Reads a value that must be there.
    pub(crate) fn need<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&'t DeValue<'t>) -> Result<T, Wrong>,
    ) -> Option<T> {
        if self.value(key).is_none() {
            self.error(
                self.at.clone(),
                key,
                Wrong::new(Rule::Missing, format!("there is no {key}")),
            );
        }
        self.read(key, read)
    }

    /// Reads each value of an array; none if one of them is wrong.
    pub(crate) fn list<T>(
        &mut self,
        key: &'static str,
        mut read: impl FnMut(&'t DeValue<'t>) -> Result<T, Wrong>,
    ) -> Option<Vec<T>> {
        let items = self.items(key)?;
        let field = self.field(key);
        let all = items.iter().map(|(value, at)| self.report.take(at.clone(), &field, read(value)));
        // Each of them is looked at before one that is wrong spoils the list.
        all.collect::<Vec<_>>().into_iter().collect()
    }

    /// The values of an array.
    pub(crate) fn items(&mut self, key: &'static str) -> Option<Vec<Value<'t>>> {
        let items = self.read(key, value::array)?;
        Some(items.iter().map(|item| (item.get_ref(), item.span())).collect())
    }

    /// The table of this name.
    pub(crate) fn table(&mut self, key: &'static str) -> Option<(&'t DeTable<'t>, Range<usize>)> {
        let at = self.span(key);
        self.read(key, value::table).map(|table| (table, at))
    }

    /// The tables of an array.
    pub(crate) fn tables(&mut self, key: &'static str) -> Vec<(&'t DeTable<'t>, Range<usize>)> {
        let field = self.field(key);
        let Some((value, at)) = self.value(key) else { return Vec::new() };
        let DeValue::Array(items) = value else {
            let help = format!("begin each with [[{}{key}]]", self.prefix);
            let wrong = value::other(value, "an array of tables").help(help);
            self.report.error(at, &field, wrong);
            return Vec::new();
        };
        (items.iter())
            .filter_map(|item| {
                let table = self.report.take(item.span(), &field, value::table(item.get_ref()));
                table.map(|table| (table, item.span()))
            })
            .collect()
    }

    /// All keys and values.
    pub(crate) fn entries(&self) -> Vec<(&'t str, Range<usize>, Value<'t>)> {
        (self.table.iter())
            .map(|(key, value)| {
                (key.get_ref().as_ref(), key.span(), (value.get_ref(), value.span()))
            })
            .collect()
    }

    pub(crate) fn error(&mut self, at: Range<usize>, key: &str, wrong: Wrong) {
        let field = self.field(key);
        self.report.error(at, &field, wrong);
    }

    pub(crate) fn field(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    /// Tells of the keys that nobody knows.
    pub(crate) fn finish(self, known: &[&str]) {
        for (key, at, _) in self.entries() {
            if !known.contains(&key) {
                let field = self.field(key);
                self.report.error(at, &field, unknown(key, known));
            }
        }
    }
}

fn unknown(key: &str, known: &[&str]) -> Wrong {
    let wrong = Wrong::new(Rule::Unknown, format!("there is no key {}", shown(key)))
        .expected(known.join(", "));
    match suggest::nearest(key, known.iter().copied()) {
        Some(near) => wrong.help(format!("did you mean {near}?")),
        None => wrong,
    }
}
