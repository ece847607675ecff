"""First seeds that no commit has run, one per bench: only the final run (``--sealed``) reads this file.

Whoever runs a bench with them to choose between two ways of doing something has opened them: draw new ones then.
"""

SEALED = {
    "invariance": 774_210_000,
    "car draws": 731_940_000,
    "motor draws": 278_630_000,
    "user mistakes": 406_130_000,
    "null logs": 591_720_000,
    "standard answers": 163_090_000,
    "fewer numbers": 852_340_000,
    "mujoco.sysid": 347_560_000,
    "new robots": 618_450_000,
}
