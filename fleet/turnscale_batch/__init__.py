# SPDX-License-Identifier: MIT
"""turnscale batch: many drives, on Dask."""
