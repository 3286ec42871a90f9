"""Events: when conditions come true within the open step, what that means for its run, and what acts then."""
