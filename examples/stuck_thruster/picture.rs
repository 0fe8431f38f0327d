//! (placeholder until the drawing lands)
