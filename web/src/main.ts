import { mount } from 'svelte';
import App from './App.svelte';
import './app.css';
import { restore_theme } from './shell/theme.svelte';

restore_theme();
const target = document.getElementById('app');
if (!target) throw new Error('index.html has no #app');
mount(App, { target });
