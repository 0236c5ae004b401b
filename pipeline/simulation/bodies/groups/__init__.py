"""Groups: many bodies that move by one rule, a module for each rule.

A new rule is a model in `pipeline/spec/group.py`, a module here and a line in `RULES`.
"""
