"""The schemes of the study: title, family, order, kind and source."""

import pandas as pd
import xarray as xr

from paper.products import table


@table(energy_error="energy_error")
def tabulate(energy_error: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    scheme = energy_error.scheme
    return pd.DataFrame(
        {
            "Scheme": scheme.scheme_title,
            "Name": scheme,
            "Family": scheme.family,
            "Order": scheme.order,
            "Kind": ["explicit" if explicit else "implicit" for explicit in scheme.explicit],
            "Source": scheme.scheme_source,
        }
    )
