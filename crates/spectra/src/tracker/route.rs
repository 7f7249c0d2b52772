//! The route by which a refresh found its pairs, and why that one.

/// How a refresh found its pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[non_exhaustive]
pub enum Route {
    /// Decomposed whole, as the parameters ask.
    Full,
    /// Decomposed whole: hardly more nodes than the search would have columns, or few nodes and
    /// nothing to start from.
    Small,
    /// Decomposed whole: a search on few nodes had not converged, or could not prove that nothing was
    /// missed. Many equal eigenvalues do that.
    Rescued,
    /// In closed form: at least as many components as pairs.
    NullSpace,
    /// Shift and invert: the factor fits in memory.
    ShiftInvert,
    /// Products with L alone: fewer operations than with its factor, or the factor would not fit in memory.
    Products,
}

impl Route {
    /// Why this way, in a few words.
    #[must_use]
    pub fn reason(self) -> &'static str {
        match self {
            Route::Full => "a full decomposition was asked for",
            Route::Small => "the graph is small",
            Route::Rescued => "the search on a small graph was not proved complete",
            Route::NullSpace => "there are at least as many components as pairs",
            Route::ShiftInvert => "the factor is sparse",
            Route::Products => {
                "the factor takes more operations than products alone, or more memory than there may be"
            }
        }
    }
}
