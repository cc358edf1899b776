"""Parts of decoration and kitchenware: jars, leaves, kitchen tools."""
