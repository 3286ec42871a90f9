"""The equations of motion and their partial derivatives."""
