//! The symmetric adjacency as a CSR that grows in place. (interface sketch: the owner of `graph` writes it)

/// Symmetric sparse matrix handed to numerical code: row-major, `f64` values, `u32` columns, columns sorted.
pub type Csr = sprs::CsMatI<f64, u32>;

/// Symmetric weighted adjacency; rows have slack, so that an edge costs amortised O(1) plus the shift inside its row.
#[derive(Clone, Debug, Default)]
pub struct Adjacency {}

#[allow(unused_variables)]
impl Adjacency {
    pub fn num_nodes(&self) -> usize {
        todo!()
    }
    /// Undirected edges; a self-loop counts once.
    pub fn num_edges(&self) -> usize {
        todo!()
    }
    /// Adds an isolated node, returns its number.
    pub fn add_node(&mut self) -> u32 {
        todo!()
    }
    /// Adds {u, v}; true if it is new (an existing edge is left as it is). u == v is a self-loop, stored once.
    pub fn add_edge(&mut self, u: u32, v: u32, weight: f64) -> bool {
        todo!()
    }
    /// Sorted neighbours of `u` (itself if it has a loop).
    pub fn neighbors(&self, u: u32) -> &[u32] {
        todo!()
    }
    pub fn weights(&self, u: u32) -> &[f64] {
        todo!()
    }
    /// Row sum, a self-loop counted once.
    pub fn degree(&self, u: u32) -> f64 {
        todo!()
    }
    /// Compact copy, O(n + nnz).
    pub fn to_csr(&self) -> Csr {
        todo!()
    }
    pub fn from_csr(csr: &Csr) -> Self {
        todo!()
    }
}
