//! What is true of a function whichever row comes to it: its graph, its
//! registers, its loops and in which functions of the source they stand.

mod owner;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use anyhow::Result;

use crate::body::{Body, Found};
use crate::image::{Function, Image};
use crate::loops::Region;
use crate::values::{Registers, follow};

/// A function, analysed.
#[derive(Debug)]
pub struct Analysis {
    /// Its graph.
    pub body: Body,
    /// What the registers hold before each instruction.
    pub registers: BTreeMap<u64, Registers>,
    /// Its loops.
    pub region: Region,
    /// The function of the source that each loop is in, by the loop's entry.
    pub owners: BTreeMap<u64, String>,
    /// What is wrong with it already.
    pub found: Vec<Found>,
}

/// The functions that have been analysed.
pub type Analyses = RefCell<BTreeMap<u64, Rc<Analysis>>>;

impl Analysis {
    /// Analyses the function, or finds that this was done.
    ///
    /// # Errors
    /// Where its bytes are no instructions, or the debug information is damaged.
    pub fn of(image: &Image, function: &Function) -> Result<Rc<Self>> {
        if let Some(known) = image.analyses.borrow().get(&function.start) {
            return Ok(Rc::clone(known));
        }
        let analysis = Rc::new(Self::new(image, function)?);
        image.analyses.borrow_mut().insert(function.start, Rc::clone(&analysis));
        Ok(analysis)
    }

    fn new(image: &Image, function: &Function) -> Result<Self> {
        let (body, mut found) = Body::read(image, function)?;
        let (registers, lost) = follow(&body, &image.isa.convention());
        found.extend(lost);
        let region = Region::of(&body);
        let mut owners = BTreeMap::new();
        for inner in region.loops() {
            owners.insert(inner.turn.entry, owner::owner(image, function, inner)?);
        }
        Ok(Self { body, registers, region, owners, found })
    }
}
