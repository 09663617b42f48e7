// A separate chunk, which vda.ts loads only when a message is opened.
import connection from '../../../src/wire/vda5050/schemas/connection.schema';
import factsheet from '../../../src/wire/vda5050/schemas/factsheet.schema';
import instantActions from '../../../src/wire/vda5050/schemas/instantActions.schema';
import order from '../../../src/wire/vda5050/schemas/order.schema';
import state from '../../../src/wire/vda5050/schemas/state.schema';
import visualization from '../../../src/wire/vda5050/schemas/visualization.schema';

export const schemas = { connection, factsheet, instantActions, order, state, visualization };
