"""What the figures of docs/trust.md are made of: one module per part, a second checker, one command for all."""
