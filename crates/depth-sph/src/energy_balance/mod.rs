//! Records of a flow: energy balance, volumes that have left and that have been eroded (sheet: depth-sph §3.4, step 11).

pub(crate) mod balance;
pub(crate) mod works;

use crate::energy_balance::balance::EnergyBalance;

/// Records of a flow since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowRecords {
    /// Energy balance.
    pub energy_balance: EnergyBalance,
    /// Volume of each node set that has left the flow (m³; m² in one dimension).
    pub outflow_volume: [f64; 2],
    /// Number of nodes that have left the flow.
    pub removed_nodes: u64,
    /// Volume of each node set that has been eroded from the bed (m³; m² in one dimension).
    pub eroded_volume: [f64; 2],
}
