"""Failures so rare that plain sampling would not see them, and the worst that inputs can do."""
