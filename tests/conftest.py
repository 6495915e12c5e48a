"""Tests that call the package work as its command does: numerical libraries keep to one thread."""

from __future__ import annotations

from tamplang.runtime.native import use_one_thread

use_one_thread()
