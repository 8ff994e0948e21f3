"""One thread at a time builds expressions.

CasADi lets other threads run while it works, and counts the uses of its constants (0, 1, 0.5, every number once)
without a lock: two threads that build expressions side by side crash the process sooner or later (casadi 3.8.2: at
once, where the expressions are of numbers alone).  Whoever builds them where threads may be, as `gough run` and
`gough reproduce` have, holds BUILDING meanwhile; machine code and CasADi's functions on numbers need no lock.
"""

from __future__ import annotations

import threading

BUILDING = threading.RLock()
