"""The equations of the whole mechanism: constraints, forces, the KKT matrix, projection."""
