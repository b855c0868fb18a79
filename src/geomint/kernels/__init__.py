"""What runs compiled: numbers, blocks, steppers, group actions. Imports nothing above itself."""

import time

STARTED = time.time()  # sources that are younger are not those that this process runs
