//! What the driver does to a shader.

use crate::support::context;
use direkt::gpu::doctor::{examine, loop_budget};

#[test]
fn every_canary_counts_and_only_known_drivers_cut_loops() {
    let context = context();
    let budget = loop_budget(&context).unwrap();
    for canary in &budget.canaries {
        assert!(
            canary.ran > 0 && canary.ran <= canary.expected,
            "{}: {canary:?}",
            context.adapter.name
        );
    }
    // Mesa 22's lavapipe ends all loops of an invocation after 65,535 iterations; nothing else is known to.
    let old_lavapipe = context.adapter.software && context.adapter.driver.contains("Mesa 22.");
    assert_eq!(
        budget.is_unlimited(),
        !old_lavapipe,
        "{:?}: {budget:?}",
        context.adapter
    );
}

#[test]
fn an_adapter_that_does_not_exist_is_not_examined() {
    assert!(examine(Some("no adapter has this name")).is_empty());
    assert!(!examine(None).is_empty());
}
