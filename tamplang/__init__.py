"""tamplang: a language and toolchain for task and motion planning of modular, self-reconfiguring robots."""

__version__ = "0.1.0"
