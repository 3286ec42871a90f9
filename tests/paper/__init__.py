"""The paper's examples: its equations against what lienumba derives, and its motions against trusted solutions."""
